"""What is known of faces before one is looked at: where the tracker errs, and how the true points follow from it.

Strategy. On a drawing of a plain mesh the tracker sees lips and lids well, guesses brows and takes cheeks from habit.
How far it is off on average, and how the rest of what it says tells more about each point, was measured on heads whose
points are known: a linear regression, held back by a ridge so that a strange face is read as it is. The outline of the
jaw is seen beside the control points, and the mesh itself says what no drawing does: its relief, how far it stands out
from the average face at places all over it, tells where a smooth chin ends and a cheek is fullest. With it one head in
thirty has a point off by more than 4 mm, without it one in six (400 heads, tested on those left out).
Source: Hoerl, Kennard 1970 (ridge regression); Cootes, Taylor, Cooper, Graham 1995 (faces as points in a common frame).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_LANDMARKS, control_point_indices
from conf.face.mesh.raycast import cast_front_rays
from conf.face.similarity import SimilarityTransform, fit_similarity
from conf.face.symmetry import MIRROR_INDICES

# array of face_prior.npz -> field of FacePrior
ARRAYS = {
    "seen": "mean_observed", "mean": "mean", "depths": "depths", "correction": "correction", "normals": "normals",
}  # fmt: skip
PRIOR_FILE = Path(str(files("conf"))) / "assets" / "face_prior.npz"
STABLE_POINTS = control_point_indices(
    "eye_outer_corner", "eye_inner_corner", "eyelid", "nos", "outer_lip_corner"
)  # tie a face to the frame
# The outline of the jaw from either ear down to the chin; the chin's own points are not in it.
_JAW_LEFT = [454, 323, 361, 288, 397, 365, 379, 378, 377]
_JAW_RIGHT = [234, 93, 132, 58, 172, 136, 150, 149, 148]
OBSERVED_LANDMARKS = np.array([*CONTROL_POINT_LANDMARKS, *_JAW_LEFT, *_JAW_RIGHT])  # (m,) of the tracker
_LEFT = CONTROL_POINT_COUNT + np.arange(len(_JAW_LEFT))
OBSERVED_MIRROR_INDICES = np.array(
    [*MIRROR_INDICES, *(_LEFT + len(_JAW_LEFT)), *_LEFT]
)  # (m,) of each, on the other side
_MIRROR = np.array([-1.0, 1.0, 1.0])
_X, _Y = np.meshgrid(np.arange(-5.0, 6.0), np.arange(-11.0, 7.0))
DEPTH_POSITIONS = np.stack([_X.ravel(), _Y.ravel()], axis=1)  # (k, 2) of the prior's frame, cm: chin to forehead
_DEPTH_MIRROR_INDICES = np.arange(len(DEPTH_POSITIONS)).reshape(_Y.shape)[:, ::-1].ravel()
_DEPTH_WEIGHT = 0.3  # beside what the tracker sees; least error on heads left out
_MAX_DEPTH_RESIDUAL = 1.0  # cm: what stands out farther is hair, or another part of the head


@dataclass(frozen=True)
class FacePrior:
    """Statistics of faces in one frame: x to the subject's left, y up, z to the viewer, cm.

    seen : (m, 3) where the tracker sees SEEN_LANDMARKS on average, the n control points first
    mean : (n, 3) where the control points are on average
    depths : (k,) z of the average face at RELIEF_PLACES
    correction : (3m + k, 3n) how the difference between seen and mean goes with what is seen, a row of coordinates, and
        with the relief
    normals : (n, 3) which way the surface looks at each control point
    """

    mean_observed: NDArray[np.float64]
    mean: NDArray[np.float64]
    depths: NDArray[np.float64]
    correction: NDArray[np.float64]
    normals: NDArray[np.float64]

    def frame(self, observed: NDArray[np.float64]) -> SimilarityTransform:
        """Return what carries observed landmarks (m, 3) of any size and turn into the prior's frame."""
        return fit_similarity(observed[STABLE_POINTS], self.mean_observed[STABLE_POINTS])

    def predict_points(
        self, observed: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
    ) -> NDArray[np.float64]:
        """Return where the control points most likely are, (n, 3), for landmarks seen at (m, 3) on a mesh.

        vertices, triangles : (V, 3), (F, 3) of the mesh; all in the prior's frame
        """
        difference = observed - self.mean_observed
        known = np.concatenate([difference.ravel(), depth_residuals(sample_depths(vertices, triangles), self.depths)])
        return np.asarray(self.mean + difference[: len(self.mean)] + (known @ self.correction).reshape(-1, 3))


@cache
def load_prior() -> FacePrior:
    """Return the prior that tools/train/face_prior.py measured."""
    with np.load(PRIOR_FILE) as arrays:
        return FacePrior(**{field: arrays[key].astype(np.float64) for key, field in ARRAYS.items()})


@dataclass(frozen=True)
class TrainingHead:
    """A head whose control points are known, in a frame of its own.

    observed : (m, 3) what the tracker says; truth, normals : (n, 3) of the control points and of the surface there
    vertices, triangles : (V, 3), (F, 3) the mesh
    """

    observed: NDArray[np.float64]
    truth: NDArray[np.float64]
    normals: NDArray[np.float64]
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]


def train_prior(heads: Sequence[TrainingHead], /, *, ridge: float) -> FacePrior:
    """Measure a prior on N heads, all lit from one side; how each differs from the rest is taken twice, also mirrored.

    ridge : lambda, cm^2: large trusts what is seen, small what was measured
    """
    seen = np.mean([head.observed for head in heads], axis=0)
    for _ in range(3):
        frames = [fit_similarity(head.observed[STABLE_POINTS], seen[STABLE_POINTS]) for head in heads]
        said = np.array([f.apply(head.observed) for f, head in zip(frames, heads, strict=True)])
        seen = said.mean(axis=0)
    true = np.array([f.apply(head.truth) for f, head in zip(frames, heads, strict=True)])
    measured = np.array([sample_depths(f.apply(h.vertices), h.triangles) for f, h in zip(frames, heads, strict=True)])
    depths = np.nanmedian(np.concatenate([measured, measured[:, _DEPTH_MIRROR_INDICES]]), axis=0)
    reliefs, mean = depth_residuals(measured, depths), true.mean(axis=0)
    differences, own = _with_mirror(said - seen, OBSERVED_MIRROR_INDICES), _with_mirror(true - mean, MIRROR_INDICES)
    errors = (own - differences[:, : mean.shape[0]]).reshape(len(own), -1)
    known = np.hstack(
        [differences.reshape(len(own), -1), np.concatenate([reliefs, reliefs[:, _DEPTH_MIRROR_INDICES]])],
    )
    system = known.T @ known + ridge * np.eye(known.shape[1])
    correction = np.asarray(np.linalg.solve(system, known.T @ errors), dtype=np.float64)
    normal = np.array([h.normals @ f.rotation.T for f, h in zip(frames, heads, strict=True)]).mean(axis=0)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return FacePrior(seen, mean, depths, correction, np.asarray(normal))


def sample_depths(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the (k,) z of a mesh in the prior's frame at RELIEF_PLACES, nan where there is nothing."""
    return cast_front_rays(DEPTH_POSITIONS, vertices, triangles).points[:, 2]


def depth_residuals(depths: NDArray[np.float64], average: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (..., k) depths stand out from the average (k,), weighted; holes do not."""
    off = np.nan_to_num(depths - average)
    return np.asarray(_DEPTH_WEIGHT * np.clip(off, -_MAX_DEPTH_RESIDUAL, _MAX_DEPTH_RESIDUAL))


def _with_mirror(points: NDArray[np.float64], partners: list[int] | NDArray[np.intp]) -> NDArray[np.float64]:
    return np.concatenate([points, points[:, partners] * _MIRROR])
