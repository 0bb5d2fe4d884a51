"""Learn how far an expression moves the control points: `python tools/train/expression.py`.

    python tools/train/expression.py [--motion FOLDER] [--output FILE]

Strategy. Ridge regression, within each track, of the control points on the tracker's own 52 weights, over facial motion
tracks and their mirror images: the mean of a track is removed from both, so that what differs between people is not
learned as expression. The tracks held out of the training of the codec are held out here too. The report leaves out one
track at a time: what share of the movement of its points the weights explain, and how far the mean of its first
quarter is from that of its last, with and without what they explain.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray

from conf.face.symmetry import MIRROR_INDICES
from conf.sender.motion.brow_reference import points_with_brows_from_bridge
from conf.sender.motion.neutral_pose import relative_pupils
from conf.sender.tracking.blendshape_network import BLENDSHAPE_NAMES, INDEX
from tools.bench.codec_link import HELD_OUT
from tools.bench.tracks import TrackReader

REPOSITORY = Path(__file__).resolve().parents[2]
MOTION = REPOSITORY.parent / "shared" / "motion"
OUTPUT = REPOSITORY / "conf" / "assets" / "expression.npz"

FPS = 15.0
RIDGE = 2.0  # weights squared, summed over frames: what hardly varies in the tracks explains nothing
QUIET_PERCENTILE = 25  # of a weight over a track, taken as that of the quiet face
_OTHER_SIDE = {"Left": "Right", "Right": "Left"}
MIRRORED = [
    next((INDEX[name.removesuffix(a) + b] for a, b in _OTHER_SIDE.items() if name.endswith(a)), INDEX[name])
    for name in BLENDSHAPE_NAMES
]


@dataclass(frozen=True)
class Sample:
    """One track. points : (N, n, 3) cm, head pose removed, pupils relative to their eye; weights : (N, 52)"""

    name: str
    points: NDArray[np.float64]
    weights: NDArray[np.float64]

    def mirrored(self) -> "Sample":
        """Return the same seen in a mirror."""
        return Sample(self.name, self.points[:, MIRROR_INDICES] * (-1, 1, 1), self.weights[:, MIRRORED])


def read_sample(reader: TrackReader, path: Path) -> Sample:
    """Return a track."""
    aligned, weights = reader.landmarks_and_shapes(path, fps=FPS)
    return Sample(path.stem, np.stack([relative_pupils(points_with_brows_from_bridge(a)) for a in aligned]), weights)


def fit_map(samples: Sequence[Sample]) -> NDArray[np.float64]:
    """Return the (52, 3 n) map from differences of weights to offsets, cm."""
    count = len(BLENDSHAPE_NAMES)
    gram, right = RIDGE * 2 * np.eye(count), np.zeros((count, samples[0].points[0].size))
    for sample in (*samples, *(sample.mirrored() for sample in samples)):
        weights = sample.weights - sample.weights.mean(axis=0)
        points = sample.points.reshape(len(sample.points), -1)
        gram += weights.T @ weights
        right += weights.T @ (points - points.mean(axis=0))
    return np.asarray(np.linalg.solve(gram, right))


def quiet_weights(samples: Sequence[Sample]) -> NDArray[np.float64]:
    """Return the (52,) weights of a typical quiet face, the same on both sides."""
    weights = np.mean([np.percentile(sample.weights, QUIET_PERCENTILE, axis=0) for sample in samples], axis=0)
    return np.asarray((weights + weights[MIRRORED]) / 2)


def report(samples: Sequence[Sample]) -> None:
    """Print how well a map learned from the others explains the movement of each track."""
    print(f"{'left out':24} explained   first to last quarter, mm: points, neutral pose")
    for left_out in samples:
        weights = fit_map([sample for sample in samples if sample is not left_out])
        points = left_out.points.reshape(len(left_out.points), -1)
        neutral = points - left_out.weights @ weights
        explained = 1 - float(neutral.var(axis=0).sum() / points.var(axis=0).sum())
        quarter = max(1, len(points) // 4)
        drifts = [10 * np.abs(p[-quarter:].mean(axis=0) - p[:quarter].mean(axis=0)).mean() for p in (points, neutral)]
        print(f"{left_out.name:24} {100 * explained:7.0f} %   " + "   ".join(f"{drift:.2f}" for drift in drifts))


def main() -> None:
    """Learn, report and write the map."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--motion", type=Path, default=MOTION, help="folder of tracks")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args()
    reader = TrackReader()
    samples = [read_sample(reader, path) for path in sorted(options.motion.glob("*.npz"))]
    report(samples)
    learned = [sample for sample in samples if sample.name not in HELD_OUT]
    weights, quiet = fit_map(learned).astype(np.float16), quiet_weights(learned).astype(np.float16)
    np.savez_compressed(options.output, map=weights, quiet=quiet)
    print(f"{options.output}: {options.output.stat().st_size} B")


if __name__ == "__main__":
    main()
