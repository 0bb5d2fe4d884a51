"""Measure the quality of the portrait: send a clip through the whole path, and compare video codecs at the same rate.

    python tools/bench/portrait.py CLIP... [--json] [--pictures FOLDER] [--no-peers] [--unlooped] [--every N]

Clips are converted to 320x240 at 15 frames/s; short ones are looped to 30 s. A loop shows again what the portrait has
learned: with --unlooped the first half of a short clip is repeated for the first ten seconds, then the second half is
shown once. --every N compares only each Nth image. Motion is coded as in a call, the chunks
of the portrait are sent in the datagrams of motion within their budget, acknowledgements arrive two frames late. The
figures exclude the first ten seconds, which have a separate row. Rates include UDP/IP headers (28 B), framing and seal;
for video RTP, UDP and IP headers (40 B).
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.portrait.chunk_budget import ChunkBudget
from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.portrait.object_sender import ObjectSender
from conf.receiver.portrait.portrait_renderer import PortraitRenderer
from conf.receiver.portrait.portrait_store import PortraitStore
from conf.render.camera import ViewState
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.scheduler import PortraitScheduler
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker, TrackedFace
from tools.bench.portrait_clip import (
    FPS,
    SIZE,
    START_S,
    Pixels,
    average,
    compare,
    load_frames,
    looped,
    similarities,
    unlooped,
)
from tools.bench.portrait_faults import artefact_fractions, lid_distances
from tools.bench.video_codecs import CODECS, transmit

FRAMING = 14 + 28  # bytes of seal and framing, and of UDP and IP headers, of each motion datagram
CHUNK_OVERHEAD = 2  # bytes that a chunk adds to its datagram besides its own
ACK_FRAMES = 2
DRAWN_SIZE = (640, 480)
RATES = (10.0, 20.0)
SSIM_TOLERANCE = 0.01  # face SSIM; images with a smaller difference count as equal


@dataclass
class Call:
    """Result of one clip: images shown, bytes sent, milliseconds of drawing."""

    sources: list[Pixels]
    trackings: list[TrackedFace | None] = field(default_factory=list)
    shown: list[Pixels | None] = field(default_factory=list)
    frozen: list[Pixels | None] = field(default_factory=list)  # the received photo without motion
    wire_bytes: list[int] = field(default_factory=list)
    motion_bytes: list[int] = field(default_factory=list)
    draw_ms: list[float] = field(default_factory=list)
    shown_at: float | None = None
    patches: int = 0
    views: int = 0


def main() -> None:
    """Print a table for each clip, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clips", type=Path, nargs="+")
    parser.add_argument("--pictures", type=Path, help="write images side by side into this folder")
    parser.add_argument("--no-peers", action="store_true", help="do not run the video codecs")
    parser.add_argument("--kbps", type=float, default=4.0, help="budget of the portrait after the start")
    parser.add_argument("--unlooped", action="store_true", help="show the second half of a short clip only once")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="compare only each Nth image")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = {}
    for clip in options.clips:
        call = run((unlooped if options.unlooped else looped)(load_frames(clip)), options.kbps)
        result, videos = measure(call, peers=() if options.no_peers else tuple(CODECS), every=options.every)
        results[clip.stem] = result
        if options.pictures:
            write_images(call, videos, options.pictures / f"{clip.stem}.jpg")
        if not options.json:
            print(table(clip.stem, result), flush=True)
    if options.json:
        print(json.dumps(results))


def run(frames: Sequence[Pixels], kbps: float) -> Call:
    """Send frames through tracker, codec, transfer of the portrait and renderer."""
    models = fetch_models()
    canonical, tracker = load_canonical_face(), FaceTracker(models)
    extractor = MotionExtractor(canonical, SIZE)
    encoder, decoder = Encoder(), Decoder()
    object_sender, object_receiver, store, budget = ObjectSender(), ObjectReceiver(), PortraitStore(), ChunkBudget(kbps)
    scheduler = PortraitScheduler(canonical, object_sender)
    call = Call(list(frames))
    with OffscreenWindow(*SIZE) as window, OffscreenWindow(*DRAWN_SIZE) as large:
        large.begin()  # a renderer must be created while its context is current
        timed = PortraitRenderer(large.ctx, store)
        window.begin()
        renderer = PortraitRenderer(window.ctx, store)
        for number, pixels in enumerate(frames):
            now = number / FPS
            tracking = tracker.track(pixels)
            call.trackings.append(tracking)
            payload = b""
            displacements = pose = None
            if tracking is not None:
                motion = extractor.update(tracking, now)
                payload = encoder.encode([motion], number)
                decoded = decoder.decode(payload, number)[0]
                displacements, pose = decoded.displacements, HeadPose.from_vector(decoded.pose)
                captured = CapturedFace(pixels, tracking.landmarks, extractor.neutral_points, extractor.fapu)
                scheduler.process_frame(captured, motion, tracking.presence, now)
            encoder.acknowledge([number - ACK_FRAMES])
            budget.add_motion(FRAMING + len(payload), now)
            chunk = object_sender.next_chunk(now, budget, overhead=CHUNK_OVERHEAD)
            call.motion_bytes.append(FRAMING + len(payload))
            call.wire_bytes.append(FRAMING + len(payload) + (len(chunk) + CHUNK_OVERHEAD if chunk else 0))
            if chunk and (data := object_receiver.receive_chunk(chunk)):
                store.receive(data)
            if ack := object_receiver.next_ack(now):
                object_sender.receive_ack(ack)
            call.frozen.append(_at_size(store.photo.pixels) if store.photo else None)
            if not renderer.ready or displacements is None or pose is None:
                call.shown.append(call.shown[-1] if call.shown else None)
                continue
            if call.shown_at is None:
                call.shown_at = now
            window.begin()
            renderer.draw(displacements, pose, ViewState(), window.framebuffer)
            window.end()
            call.shown.append(window.read())
            if number % 5 == 0:
                call.draw_ms.append(_draw_large(large, timed, displacements, pose))
        call.patches, call.views = len(store.patches), len(store.views)
    return call


def _at_size(pixels: Pixels) -> Pixels:
    """Return a photo at the size of the frames; a draft is smaller."""
    return np.asarray(cv2.resize(pixels, SIZE, interpolation=cv2.INTER_LINEAR), np.uint8)


def _draw_large(
    window: OffscreenWindow, renderer: PortraitRenderer, displacements: NDArray[np.float32], pose: HeadPose
) -> float:
    """Draw one frame and return its milliseconds, read-back included."""
    start_time = time.perf_counter()
    window.begin()
    renderer.draw(displacements, pose, ViewState(), window.framebuffer)
    window.end()
    window.read()
    return (time.perf_counter() - start_time) * 1000


def measure(call: Call, peers: Sequence[str], *, every: int = 1) -> tuple[dict[str, Any], dict[str, list[Pixels]]]:
    """Return the figures, and the frames of the video codecs at the same rate. every : only each Nth image counts"""
    models = fetch_models()
    shown = [image if number % every == 0 else None for number, image in enumerate(call.shown)]
    rows = similarities(call.sources, shown, call.trackings, FaceTracker(models))
    start = round(START_S * FPS)
    result: dict[str, Any] = {"kbps": rate(call.wire_bytes[start:]), **average(rows[start:])}
    result["artefacts_percent"] = percent(artefact_fractions(call.sources, shown, call.trackings)[start:])
    lids = [lid for lid in lid_distances(call.sources, call.shown, call.trackings)[start:] if lid is not None]
    result["lid_distance"] = round(float(np.mean(lids)), 2) if lids else None
    result["worse_than_frozen"], result["worst_below_frozen"] = below_frozen(call, start)
    result["motion_kbps"] = rate(call.motion_bytes[start:])
    result["start"] = {"kbps": rate(call.wire_bytes[:start]), **average(rows[:start])}
    result["shown_at_s"] = call.shown_at
    result["draw_ms_median_640x480"] = round(float(np.median(call.draw_ms)), 2)
    result["patches"], result["views"] = call.patches, call.views
    result["peers"] = {}
    videos = {}
    for codec in peers:
        for kbps in (result["kbps"], *RATES):
            video = transmit(call.sources, codec, kbps)
            rows_of_video = similarities(call.sources, video.frames, call.trackings, FaceTracker(models))
            name = codec if kbps == result["kbps"] else f"{codec}_{kbps:g}kbps"
            result["peers"][name] = {"kbps": rate(video.wire_bytes[start:]), **average(rows_of_video[start:])}
            result["peers"][name]["start"] = {"kbps": rate(video.wire_bytes[:start]), **average(rows_of_video[:start])}
            if kbps == result["kbps"]:
                videos[codec] = video.frames
    return result, videos


def below_frozen(call: Call, start: int) -> tuple[float, float]:
    """Return the fraction of images after the start that are worse than the photo without motion, and the maximum loss.

    Worse: the face SSIM with the source is lower by more than SSIM_TOLERANCE. The maximum loss of SSIM is over all
    images, 0 if none is lower.
    """
    losses = []
    rows = list(zip(call.sources, call.shown, call.frozen, call.trackings, strict=True))
    for source, shown, frozen, tracking in rows[start:]:
        if shown is None or frozen is None or tracking is None:
            continue
        moved, still = (compare(source, image, tracking, None).face_ssim for image in (shown, frozen))
        losses.append(still - moved)
    if not losses:
        return 0.0, 0.0
    return round(float(np.mean(np.array(losses) > SSIM_TOLERANCE)), 4), round(max(0.0, *losses), 4)


def percent(fractions: Sequence[float | None]) -> float | None:
    """Return the mean of the fractions in percent, None if there are none."""
    known = [fraction for fraction in fractions if fraction is not None]
    return round(100 * float(np.mean(known)), 3) if known else None


def rate(wire_bytes: Sequence[int]) -> float:
    """Return kbit/s from the bytes of each frame."""
    return round(sum(wire_bytes) * 8 * FPS / max(len(wire_bytes), 1) / 1000, 2)


COLUMNS = ("kbps", "face_ssim", "mouth_ssim", "face_psnr", "mouth_psnr", "landmark_error_percent", "not_found")


def table(name: str, result: dict[str, Any]) -> str:
    """Return the figures of one clip as a table."""
    shown = f"{result['shown_at_s']:.1f} s" if result["shown_at_s"] is not None else "never"
    lines = [
        f"{name}: shown after {shown}, {result['patches']} patches, {result['views']} views,",
        f"motion {result['motion_kbps']} kbit/s,",
        f"{result['worse_than_frozen']:.1%} of the images worse than the photo without motion, "
        f"at most by {result['worst_below_frozen']:.3f},",
        f"artefacts {result['artefacts_percent']} % of the pixels outside the face,",
        f"shut lids {result['lid_distance']} of 255 from the source's colour,",
        f"drawn in {result['draw_ms_median_640x480']} ms at 640x480 (median)",
        f"{'':<16}" + "".join(f"{column.replace('landmark_error_percent', 'landmark %'):>12}" for column in COLUMNS),
    ]
    rows = {"conf": result, "conf, first 10 s": result["start"], **result["peers"]}
    for label, figures in rows.items():
        cells = (figures.get(column) for column in COLUMNS)
        lines.append(f"{label:<16}" + "".join(f"{'-' if v is None else format(v, '.3f'):>12}" for v in cells))
    return "\n".join(lines) + "\n"


def write_images(call: Call, videos: dict[str, list[Pixels]], path: Path) -> None:
    """Write source, portrait and video codecs side by side, for the frames that are hardest."""
    columns: list[NDArray[np.uint8]] = []
    for number in hard_frames(call):
        views = [call.sources[number], call.shown[number], *(frames[number] for frames in videos.values())]
        columns.append(np.vstack([v if v is not None else np.zeros_like(call.sources[0]) for v in views]))
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.hstack(columns))


def hard_frames(call: Call) -> list[int]:
    """Return frame numbers after the start: widest mouth, closed eyes, largest rotations, and three evenly spaced."""
    start = round(START_S * FPS)
    tracked = [
        i for i in range(start, len(call.sources)) if call.trackings[i] is not None and call.shown[i] is not None
    ]
    points = {i: tracking.landmarks for i in tracked if (tracking := call.trackings[i]) is not None}
    size = {i: float(np.linalg.norm(p[10] - p[152])) for i, p in points.items()}
    measures = [
        lambda i: (points[i][14, 1] - points[i][13, 1]) / size[i],
        lambda i: -(points[i][145, 1] - points[i][159, 1] + points[i][374, 1] - points[i][386, 1]) / size[i],
        lambda i: (points[i][234, 2] - points[i][454, 2]) / size[i],
        lambda i: (points[i][454, 2] - points[i][234, 2]) / size[i],
        lambda i: abs(points[i][10, 2] - points[i][152, 2]) / size[i],
    ]
    even = [tracked[k] for k in np.linspace(0, len(tracked) - 1, 3).astype(int)]
    return [max(tracked, key=m) for m in measures] + even


if __name__ == "__main__":
    main()
