"""Measure time and jitter of the tracker: both backends in one run, one thread, the clip at 320x240.

    python tools/bench/tracker.py CLIP... [--frames N] [--json]

Times are the median and the minimum over the clip's frames, ms; the minimum is independent of other load on the
machine. Jitter is the standard deviation of a landmark's position in a still face: one frame of the clip repeated, each
time with new camera noise of 3 grey levels.
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.capture.clip import open_clip
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.detector import FaceDetector
from conf.sender.tracking.inference import choose_backend
from conf.sender.tracking.landmarks import Crop, LandmarkNetwork
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

SIZE = (320, 240)
NOISE = 3.0  # standard deviation of a webcam's noise indoors, grey levels
STILL_FRAMES = 60
STAGES = ("detector", "landmarks", "blendshapes", "motion", "whole")

Backend = Literal["opencv", "litert"]
Image = NDArray[np.uint8]
Result = dict[str, float]


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clips", type=Path, nargs="+", metavar="CLIP")
    parser.add_argument("--frames", type=int, default=150, help="number of frames read from each clip (default 150)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    backends: list[Backend] = ["opencv", "litert"] if choose_backend("auto") == "litert" else ["opencv"]
    results = {}
    for clip in options.clips:
        images = read_images(clip, options.frames)
        results[clip.stem] = {backend: bench(backend, images) for backend in backends}
    print(json.dumps(results) if options.json else table(results))


def read_images(clip: Path, count: int) -> list[Image]:
    """Return the first frames of a clip at SIZE."""
    with open_clip(clip) as source:
        frames = [frame for _ in range(count) if (frame := source.read()) is not None]
    return [np.asarray(cv2.resize(frame.pixels, SIZE, interpolation=cv2.INTER_AREA), np.uint8) for frame in frames]


def bench(backend: Backend, images: list[Image]) -> Result:
    """Measure the whole tracker as the sender runs it, then each stage alone."""
    models = fetch_models()
    tracker = FaceTracker(models, backend=backend)
    extractor = MotionExtractor(load_canonical_face(), SIZE)
    tracked, whole, motion = 0, [], []
    last: tuple[Image, NDArray[np.float32]] | None = None
    for i, image in enumerate(images):
        start = time.perf_counter()
        tracking = tracker.track(image)
        end = time.perf_counter()
        if tracking is None:
            continue
        extractor.update(tracking, i / 25)
        motion.append((time.perf_counter() - end) * 1000)
        whole.append((end - start) * 1000)
        tracked += 1
        last = (image, tracking.landmarks)
    if last is None:
        sys.exit("no face was found in the clip: give a clip that shows one")
    times = {"whole": whole[1:], "motion": motion} | time_stages(models, backend, *last)
    result = {f"{stage}_ms": round(float(np.median(times[stage])), 2) for stage in STAGES}
    result |= {f"{stage}_ms_fastest": round(float(np.min(times[stage])), 2) for stage in STAGES}
    result["whole_ms_mean"] = round(float(np.mean(times["whole"])), 2)
    return result | {"frames_tracked": tracked, "frames": len(images), "jitter_px": jitter(models, backend, last[0])}


def time_stages(models: Path, backend: Backend, image: Image, landmarks: NDArray[np.float32]) -> dict[str, list[float]]:
    """Return the milliseconds of sixty runs of each network, with its pre- and postprocessing."""
    crop = Crop.around_landmarks(landmarks)
    detector, landmark_network = FaceDetector(models, backend=backend), LandmarkNetwork(models, backend=backend)
    shapes = BlendshapeNetwork(models, backend=backend)
    runs: dict[str, Callable[[], object]] = {
        "detector": lambda: detector.detect(image),
        "landmarks": lambda: landmark_network.predict(image, crop),
        "blendshapes": lambda: shapes.predict(landmarks),
    }
    return {stage: [_milliseconds(run) for _ in range(60)] for stage, run in runs.items()}


def _milliseconds(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return (time.perf_counter() - start) * 1000


def jitter(models: Path, backend: Backend, image: Image) -> float:
    """Return the jitter of a still face, px of the image: standard deviation, mean over landmarks."""
    tracker, rng = FaceTracker(models, backend=backend), np.random.default_rng(0)
    rows = []
    for _ in range(STILL_FRAMES):
        noisy = np.clip(image + rng.normal(0, NOISE, image.shape), 0, 255).astype(np.uint8)
        tracking = tracker.track(noisy)
        if tracking is not None:
            rows.append(tracking.landmarks[:, :2])
    return round(float(np.std(rows[10:], axis=0).mean()), 3)


def table(results: dict[str, dict[Backend, Result]]) -> str:
    """Return the results as a table: median ms, the minimum in brackets."""
    lines = [f"{'clip':<22}{'backend':<9}" + "".join(f"{stage:>16}" for stage in STAGES) + "    mean  jitter px  found"]
    for clip, by_backend in results.items():
        for backend, result in by_backend.items():
            cells = [f"{result[f'{stage}_ms']:.2f} ({result[f'{stage}_ms_fastest']:.2f})" for stage in STAGES]
            lines.append(
                f"{clip:<22}{backend:<9}"
                + "".join(f"{cell:>16}" for cell in cells)
                + f"{result['whole_ms_mean']:>8.2f}{result['jitter_px']:>11.3f}"
                + f"  {result['frames_tracked']:.0f}/{result['frames']:.0f}"
            )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
