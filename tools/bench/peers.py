"""What a talking face costs, and how true it is: conf beside video codecs and other senders of faces.

    python tools/bench/peers.py CLIP [--plot OUT.png] [--json]

The clip is cut to 320x240 and 15 frames a second. Rates count every header: 28 B of UDP/IPv4 a datagram, 12 more of RTP
for video. Errors are mean distances in per cent of the eye distance (outer corners): for video, of the landmarks that
the tracker finds on what the receiver sees from those it finds on the source; for senders of motion, of the control
points as decoded from those that were tracked, both with the head's pose.
"""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import msgpack
import numpy as np
from numpy.typing import NDArray

from conf.output.media_writer import save_image
from conf.protocol.codec import LIVE, NARROWBAND, RICH, Profile
from conf.protocol.statistics import HEADER_BYTES, raw_frame_bytes
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import read_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker, TrackedFace
from tools.bench.codec_link import Link, measure
from tools.bench.portrait_clip import FPS, SIZE, Pixels, load_frames
from tools.bench.portrait_peers import CODECS, HEADERS, transmit
from tools.bench.scatter_chart import ScatterPoint, scatter_chart
from tools.bench.tracks import LEFT_EYE, RIGHT_EYE, Track

VIDEO_KBPS = (12.0, 16.0, 24.0, 48.0)  # with headers; the encoders stay above some of them whatever they are told
JPEG_QUALITIES = (5, 15, 30)
REPORT_DELAY = 6  # frames until a frame is acknowledged: reports twice a second, and the way there and back

# Bytes of one frame's datagram without UDP/IP headers, from each program's own format.
PACKETS = {
    "OpenSeeFace": 1785,  # its fixed packet: 68 landmarks in 2D and 3D, pose, eye and mouth features
    "VMC, blendshapes and bones": 2596,  # OSC bundles
    "Live Link Face, least": 264,
    "Live Link Face, most": 774,
    "leanest blendshape sender": 84,
}


@dataclass(frozen=True)
class Row:
    """One sender. error_percent is None where the tracker finds no face in most pictures, or none was measured."""

    name: str
    kbps: float
    error_percent: float | None
    ours: bool = False


def main() -> None:
    """Print the table, or one JSON object; draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--plot", type=Path, metavar="OUT.png")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    frames = load_frames(options.clip)
    rows = list(run(frames))
    if options.plot:
        dots = [
            ScatterPoint(row.name, row.kbps, row.error_percent, row.ours)
            for row in rows
            if row.error_percent is not None
        ]
        title = "a talking face: what it costs and how true it is"
        save_image(options.plot, scatter_chart(title, ("kbit/s with headers", "landmark error, %"), dots))
    print(json.dumps({"peers": [asdict(row) for row in rows]}) if options.json else table(rows))


def run(frames: Sequence[Pixels]) -> Iterator[Row]:
    """Yield a row for each sender."""
    tracker = FaceTracker(fetch_models())
    source = [tracker.track(pixels) for pixels in frames]
    yield Row("raw pixels", kbps(raw_frame_bytes(*SIZE) * len(frames), len(frames), packet=1200), 0.0)
    for quality in JPEG_QUALITIES:
        encoded = [cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1] for pixels in frames]
        shown = [np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8) for data in encoded]
        rate = kbps(sum(map(len, encoded)), len(frames), packet=1200)
        yield Row(f"MJPEG, quality {quality}", rate, video_error(shown, source))
    for codec in CODECS:
        for target in VIDEO_KBPS:
            video = transmit(frames, codec, target)
            rate = sum(video.wire_bytes) * 8 * FPS / len(frames) / 1000
            yield Row(f"{codec} for {target:.0f}", rate, video_error(video.frames, source))
    for name, size in PACKETS.items():
        yield Row(name, (size + HEADER_BYTES) * 8 * FPS / 1000, None)
    floats = len(msgpack.packb([0.1] * 156, use_single_float=True))
    yield Row("50 points as a list of floats, msgpack", (floats + HEADER_BYTES) * 8 * FPS / 1000, 0.0)
    for profile in (NARROWBAND, LIVE, RICH):
        yield ours(profile, source)


def ours(profile: Profile, source: Sequence[TrackedFace | None]) -> Row:
    """Send the tracked motion through the codec; rich gets its frames in between by interpolation."""
    extractor = MotionExtractor(read_canonical_face(fetch_models()), SIZE)
    seen = [tracking for tracking in source if tracking is not None]
    steps = np.arange(0, len(seen) - 1, FPS / profile.fps)
    motion, eyes = [], []
    for count, at in enumerate(steps):
        landmarks = between(seen, float(at))
        tracking = TrackedFace(landmarks, seen[round(at)].blendshapes, 1.0)
        motion.append(extractor.update(tracking, count / profile.fps))
        eyes.append(float(np.linalg.norm(landmarks[LEFT_EYE, :2] - landmarks[RIGHT_EYE, :2])) / SIZE[1])
    track = Track(profile.name, motion, np.array(eyes), extractor.fapu.lengths())
    result = measure(track, profile, Link(ack_delay=REPORT_DELAY))
    return Row(f"conf {profile.name}", result.kbps, result.error_mean_percent, ours=True)


def between(seen: Sequence[TrackedFace], at: float) -> NDArray[np.float32]:
    """Return the landmarks between two frames."""
    low = int(at)
    share = np.float32(at - low)
    high = min(low + 1, len(seen) - 1)
    return np.asarray(seen[low].landmarks * (1 - share) + seen[high].landmarks * share, np.float32)


def video_error(shown: Sequence[Pixels], source: Sequence[TrackedFace | None]) -> float | None:
    """Return the mean error of the landmarks the tracker finds on decoded pictures."""
    tracker = FaceTracker(fetch_models())
    errors = []
    for pixels, truth in zip(shown, source, strict=True):
        again = tracker.track(pixels)
        if truth is not None and again is not None:
            eyes = np.linalg.norm(truth.landmarks[LEFT_EYE, :2] - truth.landmarks[RIGHT_EYE, :2])
            offsets = np.linalg.norm(again.landmarks[:, :2] - truth.landmarks[:, :2], axis=1)
            errors.append(float(100 * offsets.mean() / eyes))
    found = sum(truth is not None for truth in source)
    return float(np.mean(errors)) if len(errors) > found / 2 else None


def kbps(size: int, frames: int, *, packet: int) -> float:
    """Return the rate of `size` bytes sent in packets, with RTP's, UDP's and IP's headers."""
    packets = max(frames, -(-size // packet))
    return (size + HEADERS * packets) * 8 * FPS / frames / 1000


def table(rows: list[Row]) -> str:
    """Return the rows for people to read, the cheapest first."""
    lines = [f"{'sender':<42}{'kbit/s':>10}{'error':>14}"]
    for row in sorted(rows, key=lambda row: row.kbps):
        error = "not measured" if row.error_percent is None else f"{row.error_percent:.2f} %"
        lines.append(f"{row.name:<42}{row.kbps:>10,.1f}{error:>14}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
