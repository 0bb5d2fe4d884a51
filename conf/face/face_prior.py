"""What is known of every face before one is looked at: the mean shape, how shapes vary, where the tracker errs.

Strategy. On a drawing of a plain mesh the tracker sees lips and lids well, guesses brows and takes cheeks from habit.
How far it is off on average, and how much that scatters, was measured on heads whose points are known. The most likely
shape given what it says is then a small linear problem: modes of shape weighed against the scatter of each point.
Source: Cootes, Taylor, Cooper, Graham 1995 (point distribution models).
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import indices
from conf.face.symmetry import PARTNERS

PRIOR_FILE = Path(str(files("conf"))) / "assets" / "face_prior.npz"
STEADY = indices("eye_outer_corner", "eye_inner_corner", "eyelid", "nos", "outer_lip_corner")  # tie a face to the frame
_MIRROR = np.array([-1.0, 1.0, 1.0])
_LEAST_SCATTER = 0.05  # cm


@dataclass(frozen=True)
class Similarity:
    """A turn, a size and a shift: target = scale * rotation @ source + shift."""

    rotation: NDArray[np.float64]
    scale: float
    shift: NDArray[np.float64]

    def apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Carry (..., 3) points."""
        return np.asarray(self.scale * points @ self.rotation.T + self.shift)

    def undo(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Carry (..., 3) points back."""
        return np.asarray((points - self.shift) @ self.rotation / self.scale)


def fit_similarity(source: NDArray[np.float64], target: NDArray[np.float64]) -> Similarity:
    """Find the similarity that carries points (K, 3) nearest to points (K, 3). Source: Umeyama 1991."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    rotation = Rotation.align_vectors(b, a)[0].as_matrix()
    scale = float((b * (a @ rotation.T)).sum() / (a * a).sum())
    return Similarity(rotation, scale, target.mean(axis=0) - scale * rotation @ source.mean(axis=0))


@dataclass(frozen=True)
class FacePrior:
    """Statistics of faces in one frame: x to the subject's left, y up, z to the viewer, cm.

    seen : (n, 3) where the tracker sees the control points on average
    mean : (n, 3) where they are on average
    scatter : (n, 3) standard deviation of what the tracker says about what is true, its mean error taken out
    modes : (k, n, 3) how shapes vary, each as long as its standard deviation
    normals : (n, 3) which way the surface looks at each control point
    """

    seen: NDArray[np.float64]
    mean: NDArray[np.float64]
    scatter: NDArray[np.float64]
    modes: NDArray[np.float64]
    normals: NDArray[np.float64]

    def frame(self, observed: NDArray[np.float64]) -> Similarity:
        """Return what carries observed control points (n, 3) of any size and turn into the prior's frame."""
        return fit_similarity(observed[STEADY], self.seen[STEADY])

    def likely_shape(self, observed: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the most likely true control points (n, 3) for observed ones, all in the prior's frame."""
        weights = 1 / np.maximum(self.scatter, _LEAST_SCATTER).ravel() ** 2
        modes = self.modes.reshape(len(self.modes), -1)
        system = (modes * weights) @ modes.T + np.eye(len(modes))
        amounts = np.linalg.solve(system, (modes * weights) @ (observed - self.seen).ravel())
        return np.asarray(self.mean + (amounts @ modes).reshape(-1, 3))


@cache
def load_prior() -> FacePrior:
    """Return the prior that tools/train_fit.py measured."""
    with np.load(PRIOR_FILE) as arrays:
        return FacePrior(**{name: arrays[name].astype(np.float64) for name in FacePrior.__dataclass_fields__})


def learn_prior(
    observed: NDArray[np.float64], truth: NDArray[np.float64], normals: NDArray[np.float64], /, *, modes: int
) -> FacePrior:
    """Measure a prior on N heads, each taken twice: as it is and mirrored.

    observed, truth : (N, n, 3) what the tracker says and what is true, each head in a frame of its own
    normals : (N, n, 3) of the surface at the true points, in the same frames
    """
    seen = _mirrored_mean(observed)
    for _ in range(3):
        frames = [fit_similarity(points[STEADY], seen[STEADY]) for points in observed]
        seen = _mirrored_mean(np.array([f.apply(points) for f, points in zip(frames, observed, strict=True)]))
    true = _with_mirror(np.array([f.apply(points) for f, points in zip(frames, truth, strict=True)]))
    said = _with_mirror(np.array([f.apply(points) for f, points in zip(frames, observed, strict=True)]))
    turned = _with_mirror(np.array([n @ f.rotation.T for f, n in zip(frames, normals, strict=True)]))
    mean = true.mean(axis=0)
    scatter = ((said - seen) - (true - mean)).std(axis=0)
    _, sizes, directions = np.linalg.svd((true - mean).reshape(len(true), -1), full_matrices=False)
    spread = sizes[:modes, None] / np.sqrt(len(true)) * directions[:modes]
    normal = turned.mean(axis=0)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return FacePrior(seen, mean, scatter, spread.reshape(-1, *mean.shape), normal)


def _with_mirror(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([points, points[:, PARTNERS] * _MIRROR])


def _mirrored_mean(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(_with_mirror(points).mean(axis=0))
