"""Measure the time that reading a clip takes, ms a frame, beside OpenCV's VideoCapture in the same run.

    python tools/bench/clip_reader.py [CLIP...] [--frames 150] [--rounds 7] [--json]

Without clips, some are generated: H.264, MPEG-4, MPEG-2 and Motion JPEG in three sizes. Both readers read the same clip
in turn, each from opening to the last frame; the medians of the rounds are compared. `least` compares the fastest round
of both, which other load on the machine changes least. Opening counts: `open` is the time to the first frame, ms. Both
decode with as many threads as FFmpeg chooses.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import av
import cv2
import numpy as np

from conf.sender.capture.clip import open_clip

TARGET = 1.5
SIZES = ((320, 240), (640, 480), (1280, 720))
CODECS = {"libx264": "mp4", "mpeg4": "avi", "mpeg2video": "mpg", "mjpeg": "mov"}


@dataclass(frozen=True)
class Timing:
    """Medians for one clip: ms a frame of both readers, their ratio, ms to the first frame of both.

    least_ratio : of the fastest rounds
    """

    clip: str
    coding: str
    width: int
    height: int
    frames: int
    ours_ms: float
    opencv_ms: float
    ratio: float
    least_ratio: float
    ours_open_ms: float
    opencv_open_ms: float


Reading = tuple[int, float, float]  # frames, seconds in all, seconds to the first frame


def read_ours(path: Path, limit: int) -> Reading:
    """Read at most `limit` frames with conf's reader."""
    start = time.perf_counter()
    with open_clip(path) as clip:
        return _count(start, lambda: clip.read() is not None, limit)


def read_opencv(path: Path, limit: int) -> Reading:
    """Read at most `limit` frames with OpenCV."""
    start = time.perf_counter()
    capture = cv2.VideoCapture(str(path))
    try:
        return _count(start, lambda: capture.read()[0], limit)
    finally:
        capture.release()


def _count(start: float, read: Callable[[], bool], limit: int) -> Reading:
    frames, first = 0, start
    while frames < limit and read():
        frames += 1
        first = time.perf_counter() if frames == 1 else first
    return frames, time.perf_counter() - start, first - start


def compare(path: Path, *, frames: int, rounds: int) -> Timing:
    """Read a clip in turn with both readers. Raises SystemExit if they do not find the same frames."""
    pairs = [(read_ours(path, frames), read_opencv(path, frames)) for _ in range(rounds)]
    ours, opencv = zip(*pairs, strict=True)
    if abs(ours[0][0] - opencv[0][0]) > 1:  # OpenCV drops the last frame of some containers
        raise SystemExit(f"{path}: {ours[0][0]} frames, {opencv[0][0]} by OpenCV")
    ours_ms, opencv_ms = (1000 * median(s / max(n, 1) for n, s, _ in readings) for readings in (ours, opencv))
    least = [min(s / max(n, 1) for n, s, _ in readings) for readings in (ours, opencv)]
    with open_clip(path) as clip, av.open(str(path)) as container:
        coding, (width, height) = container.streams.video[0].codec_context.name, clip.size
    ours_open_ms, opencv_open_ms = (1000 * median(first for *_, first in readings) for readings in (ours, opencv))
    return Timing(
        path.name, coding, width, height, ours[0][0], ours_ms, opencv_ms, ours_ms / opencv_ms,
        least[0] / least[1], ours_open_ms, opencv_open_ms,
    )  # fmt: skip


def generate(folder: Path, frames: int) -> Iterator[Path]:
    """Write a clip of each codec and size: a smooth image with camera noise that moves by some pixels a frame."""
    rng = np.random.default_rng(1)
    for width, height in SIZES:
        base = cv2.resize(rng.integers(0, 255, (24, 40, 3)).astype(np.uint8), (width + 64, height + 64))
        noise = rng.normal(0, 3, base.shape)
        images = []
        for i in range(16):
            x, y = round(16 + 16 * np.cos(i / 2.5)), round(16 + 16 * np.sin(i / 2.5))
            shifted = base[y : y + height, x : x + width] + np.roll(noise, 37 * i, axis=0)[:height, :width]
            images.append(shifted.clip(0, 255).astype(np.uint8))
        for codec, suffix in CODECS.items():
            path = folder / f"{codec}_{width}x{height}.{suffix}"
            with av.open(str(path), "w") as container:
                stream: Any = container.add_stream(codec, rate=25)
                stream.width, stream.height = width, height
                stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
                stream.bit_rate = 4 * width * height
                for i in range(frames):
                    frame = av.VideoFrame.from_ndarray(images[i % len(images)], format="bgr24")
                    frame.pts, frame.time_base = i, Fraction(1, 25)
                    container.mux(stream.encode(frame.reformat(format=stream.pix_fmt)))
                container.mux(stream.encode())
            yield path


def table(timings: list[Timing]) -> str:
    """Return one line a clip and the summary."""
    lines = [
        "clip                        coding      size        frames  ours ms  OpenCV ms  ratio  least  open ms (both)"
    ]
    lines += [
        f"{t.clip:27} {t.coding:11} {f'{t.width}x{t.height}':11} {t.frames:6} {t.ours_ms:8.2f} {t.opencv_ms:10.2f} "
        f"{t.ratio:6.2f} {t.least_ratio:6.2f}  {t.ours_open_ms:.1f} / {t.opencv_open_ms:.1f}"
        for t in timings
    ]
    ratios = [t.ratio for t in timings]
    least = [t.least_ratio for t in timings]
    lines.append(
        f"ratio: median {median(ratios):.2f}, largest {max(ratios):.2f}; of the fastest rounds {median(least):.2f}, "
        f"{max(least):.2f}; target {TARGET}"
    )
    return "\n".join(lines)


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", type=Path, nargs="*", metavar="CLIP")
    parser.add_argument("--frames", type=int, default=150, help="read at most this many frames (default 150)")
    parser.add_argument("--rounds", type=int, default=7, help="readings of each clip by both (default 7)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        clips = options.clips or list(generate(Path(name), options.frames))
        timings = [compare(clip, frames=options.frames, rounds=options.rounds) for clip in clips]
    result = {"target": TARGET, "clips": [asdict(timing) for timing in timings]}
    print(json.dumps(result) if options.json else table(timings))


if __name__ == "__main__":
    main()
