"""Learn the map from control points to ARKit blendshape weights: `python tools/train/arkit.py`.

    python tools/train/arkit.py [--motion FOLDER] [--output FILE]

Strategy. Ridge regression of the tracker's own 52 weights on the displacements and their sizes, over facial motion
tracks and their mirror images. Tracks of people hold few of the 52 shapes, so random mixtures of the shipped head's
sculpted shapes are learned from as well: an emotion, or a shape that nobody made, gets its weight, and a face at rest
hardly any. Of two opposites the difference is learned, so that never both are above 0. A track counts by the root of
its length. The report leaves out one track at a time: its figures are of people the map has not seen.
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

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.retargeting.arkit_csv import OPPOSITES, SHAPES, shape_features
from conf.face.symmetry import mirror_motion
from conf.sender.tracking.blendshape_network import to_arkit_order
from tools.assets.arkit_shapes import load_arkit_shapes
from tools.bench.tracks import TrackReader

REPOSITORY = Path(__file__).resolve().parents[2]
MOTION = REPOSITORY.parent / "shared" / "motion"
OUTPUT = REPOSITORY / "conf" / "assets" / "arkit.npz"

FPS = 25.0
RIDGE = 30.0
SCALE_OFFSET = 20.0  # FAPU units: a coordinate that hardly moves is not enlarged
MIXTURES = 3000
SHAPES_IN_MIXTURE = 4  # at most
MOVING = 0.05  # standard deviation over all tracks from which a shape is reported
MIRRORED = [SHAPES.index(name.replace("Left", "-").replace("Right", "Left").replace("-", "Right")) for name in SHAPES]
FEATURES = 6 * CONTROL_POINT_COUNT + 1
# Shapes of the eyes depend on the features of the eyes only: a blink during speech is as deep as in silence.
_EYE_POINTS = np.repeat([point.name.startswith(("eye", "pupil")) for point in CONTROL_POINTS], 3)
OF_EYES = np.concatenate([_EYE_POINTS, _EYE_POINTS, [True]])
PAIRS = [(SHAPES.index(first), SHAPES.index(second)) for first, second in OPPOSITES]


@dataclass(frozen=True)
class Sample:
    """Motion with known weights. displacements : (N, n, 3) FAPU units; weights : (N, 52); influence : of a frame"""

    name: str
    displacements: NDArray[np.float64]
    weights: NDArray[np.float64]
    influence: float

    def mirrored(self) -> "Sample":
        """Return the same seen in a mirror."""
        displacements = np.array([mirror_motion(motion) for motion in self.displacements], np.float64)
        return Sample(self.name, displacements, self.weights[:, MIRRORED], self.influence)


def read_sample(reader: TrackReader, path: Path) -> Sample:
    """Return a track with the weights that the tracker's network gives it."""
    motion, shapes = reader.motion_and_shapes(path, fps=FPS)
    return Sample(path.stem, motion, to_arkit_order(shapes).astype(np.float64), len(motion) ** -0.5)


def sculpted_mixtures(seed: int = 0) -> Sample:
    """Return mixtures of a few sculpted shapes without opposites."""
    random = np.random.default_rng(seed)
    weights = np.zeros((MIXTURES, len(SHAPES)))
    for row in weights:
        chosen = random.choice(len(SHAPES), random.integers(SHAPES_IN_MIXTURE + 1), replace=False)
        row[chosen] = random.uniform(0, 1, len(chosen))
    for first, second in PAIRS:
        weights[weights[:, first] > 0, second] = 0
    shapes = np.stack([load_arkit_shapes()[name] for name in SHAPES])
    return Sample("sculpted", np.asarray(np.einsum("ns,spi->npi", weights, shapes), np.float64), weights, 1.0)


def fit_map(tracks: Sequence[Sample], mixtures: Sample, scale: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (6 n + 1, 52) map."""
    people = [*tracks, *(track.mirrored() for track in tracks)]
    mean = np.concatenate([np.full(len(s.weights), s.influence) for s in people]).mean()
    gram = np.zeros((FEATURES, FEATURES))
    right = np.zeros((FEATURES, len(SHAPES)))
    for sample in (*people, mixtures, mixtures.mirrored()):
        influence = sample.influence if sample.name == mixtures.name else sample.influence / mean
        features = shape_features(sample.displacements, scale)
        weights = sample.weights.copy()
        for first, second in PAIRS:
            weights[:, first] -= weights[:, second]
            weights[:, second] = -weights[:, first]
        gram += influence * features.T @ features
        right += influence * features.T @ weights
    gram[np.diag_indices(FEATURES - 1)] += RIDGE
    solved = np.zeros_like(right)
    of_eyes = np.array([name.startswith("eye") for name in SHAPES])
    for shapes, used in (of_eyes, OF_EYES), (~of_eyes, np.ones(FEATURES, bool)):
        solved[np.ix_(used, shapes)] = np.linalg.solve(gram[np.ix_(used, used)], right[np.ix_(used, shapes)])
    return solved


def predict(samples: Sample, weights: NDArray[np.float64], scale: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (N, 52) weights that a map gives."""
    return np.clip(shape_features(samples.displacements, scale) @ weights, 0, 1)


def report(tracks: Sequence[Sample], mixtures: Sample, scale: NDArray[np.float64]) -> None:
    """Print how well a map learned from the others gives each track's weights."""
    moving = np.concatenate([track.weights for track in tracks]).std(axis=0) > MOVING
    errors, peaks, both = [], [], []
    print(f"{'left out':24} mean error   blink's peak, left and right: tracker, map")
    for left_out in tracks:
        others = [track for track in tracks if track is not left_out]
        predicted = predict(left_out, fit_map(others, mixtures, scale), scale)
        errors.append(float(np.abs(predicted - left_out.weights)[:, moving].mean()))
        blinks = [SHAPES.index(f"eyeBlink{side}") for side in ("Left", "Right")]
        pairs = [(left_out.weights[:, i].max(), predicted[:, i].max()) for i in blinks]
        peaks += [mapped - own for own, mapped in pairs]
        both += [np.minimum(predicted[:, a], predicted[:, b]).max() for a, b in PAIRS]
        print(f"{left_out.name:24} {errors[-1]:.3f}       " + "   ".join(f"{a:.2f}, {b:.2f}" for a, b in pairs))
    differences = np.abs(peaks)
    print(f"mean error {np.mean(errors):.3f} over {moving.sum()} shapes that move")
    print(
        f"blink's peak: off by {differences.mean():.3f} on average, {(differences > 0.1).sum()} of {len(peaks)} by > .1"
    )
    print(f"smaller one of two opposites: at most {max(both):.3f}")


def main() -> None:
    """Learn, report and write the map."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motion", type=Path, default=MOTION, help="folder of tracks")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args()
    reader = TrackReader()
    tracks = [read_sample(reader, path) for path in sorted(options.motion.glob("*.npz"))]
    mixtures = sculpted_mixtures()
    motion = np.concatenate([track.displacements for track in tracks])
    scale = motion.reshape(len(motion), -1).std(axis=0) + SCALE_OFFSET
    report(tracks, mixtures, scale)
    weights = fit_map(tracks, mixtures, scale)
    np.savez_compressed(options.output, map=weights.astype(np.float16), scale=scale.astype(np.float32))
    print(f"{options.output}: {options.output.stat().st_size} B")


if __name__ == "__main__":
    main()
