"""What is known of faces before one is looked at: where the tracker errs, and how the true points follow from it.

Strategy. On a drawing of a plain mesh the tracker sees lips and lids well, guesses brows and takes cheeks from habit.
How far it is off on average, and how the rest of what it says tells more about each point, was measured on heads whose
points are known: a linear regression, held back by a ridge so that a strange face is read as it is. The outline of the
jaw is seen beside the control points: it says how broad and how long the chin is.
Source: Hoerl, Kennard 1970 (ridge regression); Cootes, Taylor, Cooper, Graham 1995 (faces as points in a common frame).
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, LANDMARKS, indices
from conf.face.similarity import Similarity, fit_similarity
from conf.face.symmetry import PARTNERS

PRIOR_FILE = Path(str(files("conf"))) / "assets" / "face_prior.npz"
STEADY = indices("eye_outer_corner", "eye_inner_corner", "eyelid", "nos", "outer_lip_corner")  # tie a face to the frame
# The outline of the jaw from either ear down to the chin; the chin's own points are not in it.
_JAW_LEFT = [454, 323, 361, 288, 397, 365, 379, 378, 377]
_JAW_RIGHT = [234, 93, 132, 58, 172, 136, 150, 149, 148]
SEEN_LANDMARKS = np.array([*LANDMARKS, *_JAW_LEFT, *_JAW_RIGHT])  # (m,) of the tracker
_LEFT = CONTROL_POINT_COUNT + np.arange(len(_JAW_LEFT))
SEEN_PARTNERS = np.array([*PARTNERS, *(_LEFT + len(_JAW_LEFT)), *_LEFT])  # (m,) of each, on the other side
_MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True)
class FacePrior:
    """Statistics of faces in one frame: x to the subject's left, y up, z to the viewer, cm.

    seen : (m, 3) where the tracker sees SEEN_LANDMARKS on average, the n control points first
    mean : (n, 3) where the control points are on average
    correction : (3m, 3n) how the difference between the two goes with what is seen: a row of coordinates times it
    normals : (n, 3) which way the surface looks at each control point
    """

    seen: NDArray[np.float64]
    mean: NDArray[np.float64]
    correction: NDArray[np.float64]
    normals: NDArray[np.float64]

    def frame(self, observed: NDArray[np.float64]) -> Similarity:
        """Return what carries observed landmarks (m, 3) of any size and turn into the prior's frame."""
        return fit_similarity(observed[STEADY], self.seen[STEADY])

    def likely_points(self, observed: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the control points most likely are, (n, 3), for landmarks seen at (m, 3): the prior's frame."""
        difference = observed - self.seen
        corrected = difference[: len(self.mean)] + (difference.ravel() @ self.correction).reshape(-1, 3)
        return np.asarray(self.mean + corrected)


@cache
def load_prior() -> FacePrior:
    """Return the prior that tools/train_fit.py measured."""
    with np.load(PRIOR_FILE) as arrays:
        return FacePrior(**{name: arrays[name].astype(np.float64) for name in FacePrior.__dataclass_fields__})


def learn_prior(
    observed: NDArray[np.float64], truth: NDArray[np.float64], normals: NDArray[np.float64], /, *, ridge: float
) -> FacePrior:
    """Measure a prior on N heads, all lit from one side; how each differs from the rest is taken twice, also mirrored.

    observed, truth : (N, m, 3) what the tracker says, (N, n, 3) what is true, each head in a frame of its own
    normals : (N, n, 3) of the surface at the true points, in the same frames
    ridge : lambda, cm^2: large trusts what is seen, small what was measured
    """
    seen = observed.mean(axis=0)
    for _ in range(3):
        frames = [fit_similarity(points[STEADY], seen[STEADY]) for points in observed]
        said = np.array([f.apply(points) for f, points in zip(frames, observed, strict=True)])
        seen = said.mean(axis=0)
    true = np.array([f.apply(points) for f, points in zip(frames, truth, strict=True)])
    mean = true.mean(axis=0)
    differences, own = _with_mirror(said - seen, SEEN_PARTNERS), _with_mirror(true - mean, PARTNERS)
    errors = own - differences[:, : mean.shape[0]]
    differences, errors = differences.reshape(len(own), -1), errors.reshape(len(own), -1)
    system = differences.T @ differences + ridge * np.eye(differences.shape[1])
    correction = np.asarray(np.linalg.solve(system, differences.T @ errors), dtype=np.float64)
    normal = np.array([n @ f.rotation.T for f, n in zip(frames, normals, strict=True)]).mean(axis=0)
    return FacePrior(seen, mean, correction, np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True)))


def _with_mirror(points: NDArray[np.float64], partners: list[int] | NDArray[np.intp]) -> NDArray[np.float64]:
    return np.concatenate([points, points[:, partners] * _MIRROR])
