"""Compare bit rate and error of conf with those of video codecs and of other programs that send facial motion.

    python tools/bench/peers.py CLIP [--plot OUT.png] [--json]

The clip is converted to 320x240 at 15 frames/s. Rates include all headers: 28 B of UDP/IPv4 a datagram, and 12 B of RTP
for video. Errors are mean distances in per cent of the distance of the outer eye corners: for video, between the
landmarks tracked in the decoded and in the source frame; for senders of motion, between the decoded and the tracked
control points, both with the head pose.
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

from conf.output.image_writer import save_image
from conf.protocol.codec.profiles import LIVE, NARROWBAND, RICH, Profile
from conf.protocol.statistics import HEADER_BYTES, raw_frame_bytes
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker, TrackedFace
from tools.bench.codec_link import Link, measure
from tools.bench.portrait_clip import FPS, SIZE, Pixels, load_frames
from tools.bench.scatter_chart import ScatterPoint, scatter_chart
from tools.bench.tracks import LEFT_EYE, RIGHT_EYE, Track
from tools.bench.video_codecs import CODECS, HEADERS, transmit

VIDEO_KBPS = (12.0, 16.0, 24.0, 48.0)  # targets, with headers; some encoders stay above the lowest
JPEG_QUALITIES = (5, 15, 30)
REPORT_DELAY = 6  # frames until a frame is acknowledged: two reports a second, and the round trip

# Bytes of the datagram of one frame without UDP/IP headers, from the format of each program.
PACKETS = {
    "OpenSeeFace": 1785,  # its fixed packet: 68 landmarks in 2D and 3D, pose, eye and mouth features
    "VMC, blendshapes and bones": 2596,  # OSC bundles
    "Live Link Face, least": 264,
    "Live Link Face, most": 774,
    "leanest blendshape sender": 84,
}


@dataclass(frozen=True)
class Row:
    """One sender. error_percent is None if no face was found in most images or the error was not measured."""

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
        points = [
            ScatterPoint(row.name, row.kbps, row.error_percent, row.ours)
            for row in rows
            if row.error_percent is not None
        ]
        title = "a talking face: bit rate and error"
        save_image(options.plot, scatter_chart(title, ("kbit/s with headers", "landmark error, %"), points))
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
    """Return the row of a profile; motion at a higher frame rate than the clip's is interpolated."""
    extractor = MotionExtractor(load_canonical_face(), SIZE)
    tracked = [tracking for tracking in source if tracking is not None]
    steps = np.arange(0, len(tracked) - 1, FPS / profile.fps)
    motion, eye_distances = [], []
    for number, index in enumerate(steps):
        landmarks = interpolate(tracked, float(index))
        tracking = TrackedFace(landmarks, tracked[round(index)].blendshapes, 1.0)
        motion.append(extractor.update(tracking, number / profile.fps))
        eye_distances.append(float(np.linalg.norm(landmarks[LEFT_EYE, :2] - landmarks[RIGHT_EYE, :2])) / SIZE[1])
    track = Track(profile.name, motion, np.array(eye_distances), extractor.fapu)
    result = measure(track, profile, Link(ack_delay=REPORT_DELAY))
    return Row(f"conf {profile.name}", result.kbps, result.error_mean_percent, ours=True)


def interpolate(tracked: Sequence[TrackedFace], index: float) -> NDArray[np.float32]:
    """Return the landmarks at a fractional frame index, linearly interpolated."""
    low = int(index)
    weight = np.float32(index - low)
    high = min(low + 1, len(tracked) - 1)
    return np.asarray(tracked[low].landmarks * (1 - weight) + tracked[high].landmarks * weight, np.float32)


def video_error(shown: Sequence[Pixels], source: Sequence[TrackedFace | None]) -> float | None:
    """Return the mean error of the landmarks that the tracker finds in decoded frames, or None."""
    tracker = FaceTracker(fetch_models())
    errors = []
    for pixels, truth in zip(shown, source, strict=True):
        tracking = tracker.track(pixels)
        if truth is not None and tracking is not None:
            eye_distance = np.linalg.norm(truth.landmarks[LEFT_EYE, :2] - truth.landmarks[RIGHT_EYE, :2])
            offsets = np.linalg.norm(tracking.landmarks[:, :2] - truth.landmarks[:, :2], axis=1)
            errors.append(float(100 * offsets.mean() / eye_distance))
    found = sum(truth is not None for truth in source)
    return float(np.mean(errors)) if len(errors) > found / 2 else None


def kbps(size: int, frames: int, *, packet: int) -> float:
    """Return the rate of `size` bytes in so many frames, sent in packets with RTP, UDP and IP headers."""
    packets = max(frames, -(-size // packet))
    return (size + HEADERS * packets) * 8 * FPS / frames / 1000


def table(rows: list[Row]) -> str:
    """Return the rows as a table, by ascending rate."""
    lines = [f"{'sender':<42}{'kbit/s':>10}{'error':>14}"]
    for row in sorted(rows, key=lambda row: row.kbps):
        error = "not measured" if row.error_percent is None else f"{row.error_percent:.2f} %"
        lines.append(f"{row.name:<42}{row.kbps:>10,.1f}{error:>14}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
