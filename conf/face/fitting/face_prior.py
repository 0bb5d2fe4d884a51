"""Statistics of faces: the tracker's mean error at each control point, and a regression that corrects it.

Strategy. On a rendering of an untextured mesh the tracker finds lips and lids well; brows it guesses, and cheeks it
places by habit. Its mean error, and how the error of each point depends on the other observations, was measured on
heads with known control points: a linear regression, ridge-regularised so that an unusual face is read as it is. The
outline of the jaw is observed besides the control points, and so is the depth of the mesh relative to the mean face on
a grid, which shows where a smooth chin ends and where a cheek is fullest. With the depths one head in thirty has a
point off by more than 4 mm, without them one in six (400 heads, cross-validated).
tools/train/face_prior.py computes the statistics.
Source: Hoerl, Kennard 1970 (ridge regression); Cootes, Taylor, Cooper, Graham 1995 (faces as points in a common frame).
"""

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

PRIOR_FILE = Path(str(files("conf"))) / "assets" / "face_prior.npz"
# array of face_prior.npz -> field of FacePrior
ARRAYS = {
    "seen": "mean_observed", "mean": "mean", "depths": "depths", "correction": "correction", "normals": "normals",
}  # fmt: skip
# The points that align a face with the prior's frame.
STABLE_POINTS = control_point_indices("eye_outer_corner", "eye_inner_corner", "eyelid", "nos", "outer_lip_corner")
# The outline of the jaw from either ear down to the chin, without the control points of the chin.
_JAW_LEFT = [454, 323, 361, 288, 397, 365, 379, 378, 377]
_JAW_RIGHT = [234, 93, 132, 58, 172, 136, 150, 149, 148]
OBSERVED_LANDMARKS = np.array([*CONTROL_POINT_LANDMARKS, *_JAW_LEFT, *_JAW_RIGHT])  # (m,) of the tracker
_LEFT = CONTROL_POINT_COUNT + np.arange(len(_JAW_LEFT))
OBSERVED_MIRROR_INDICES = np.array([*MIRROR_INDICES, *(_LEFT + len(_JAW_LEFT)), *_LEFT])  # (m,) on the other side
_X, _Y = np.meshgrid(np.arange(-5.0, 6.0), np.arange(-11.0, 7.0))
DEPTH_POSITIONS = np.stack([_X.ravel(), _Y.ravel()], axis=1)  # (k, 2) in the prior's frame, cm: chin to forehead
DEPTH_MIRROR_INDICES = np.arange(len(DEPTH_POSITIONS)).reshape(_Y.shape)[:, ::-1].ravel()  # (k,) on the other side
_DEPTH_WEIGHT = 0.3  # relative to the observed landmarks; the value with the least cross-validated error
_MAX_DEPTH_RESIDUAL = 1.0  # cm: what stands out farther is hair, or another part of the head


@dataclass(frozen=True)
class FacePrior:
    """Statistics of faces in one frame: x to the subject's left, y up, z to the viewer, cm.

    mean_observed : (m, 3) mean position of OBSERVED_LANDMARKS in the tracker's output, the n control points first
    mean : (n, 3) mean position of the control points
    depths : (k,) z of the mean face at DEPTH_POSITIONS
    correction : (3m + k, 3n) regression from observed residuals (row of coordinates) and depth residuals to the error
    normals : (n, 3) mean surface normal at each control point
    """

    mean_observed: NDArray[np.float64]
    mean: NDArray[np.float64]
    depths: NDArray[np.float64]
    correction: NDArray[np.float64]
    normals: NDArray[np.float64]

    def frame(self, observed: NDArray[np.float64]) -> SimilarityTransform:
        """Return the similarity that aligns observed landmarks (m, 3) of any scale and rotation with the prior."""
        return fit_similarity(observed[STABLE_POINTS], self.mean_observed[STABLE_POINTS])

    def predict_points(
        self, observed: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
    ) -> NDArray[np.float64]:
        """Return the most likely control points, (n, 3), for landmarks (m, 3) observed on a mesh (V, 3), (F, 3).

        All in the prior's frame.
        """
        residuals = observed - self.mean_observed
        depths = depth_residuals(sample_depths(vertices, triangles), self.depths)
        correction = np.concatenate([residuals.ravel(), depths]) @ self.correction
        return np.asarray(self.mean + residuals[: len(self.mean)] + correction.reshape(-1, 3))


@cache
def load_prior() -> FacePrior:
    """Return the prior measured by tools/train/face_prior.py."""
    with np.load(PRIOR_FILE) as arrays:
        return FacePrior(**{field: arrays[key].astype(np.float64) for key, field in ARRAYS.items()})


def sample_depths(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the (k,) z of a mesh in the prior's frame at DEPTH_POSITIONS, nan where a ray misses it."""
    return cast_front_rays(DEPTH_POSITIONS, vertices, triangles).points[:, 2]


def depth_residuals(depths: NDArray[np.float64], mean: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weighted, clipped differences of depths (..., k) from the mean (k,), 0 where a depth is nan."""
    residuals = np.nan_to_num(depths - mean)
    return np.asarray(_DEPTH_WEIGHT * np.clip(residuals, -_MAX_DEPTH_RESIDUAL, _MAX_DEPTH_RESIDUAL))
