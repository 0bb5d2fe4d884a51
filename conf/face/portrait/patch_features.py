"""The parts of a face that a patch can show: which control points carry each, how far it reaches, what it is doing.

What a part is doing is told by a few keys, in steps of the motion's own units, the same on both sides of a call: the
sender adds a patch when the keys are far from all that it has sent, the receiver shows the patches with the nearest.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours

Displacements = NDArray[np.floating]
DESCRIPTOR_STEP = 16.0  # FAPU units in one step of a key


@dataclass(frozen=True)
class PatchRegion:
    """A part of the face.

    points : control points that carry its patches
    core : landmarks; a patch is whole within `reach[0]` cm of them and gone at `reach[1]`
    keys : turns displacements (n, 3) into what the part is doing, FAPU units
    """

    name: str
    points: tuple[int, ...]
    centre_landmarks: tuple[int, ...]
    falloff_cm: tuple[float, float]
    descriptor: Callable[[Displacements], list[float]]

    def weights(self, flat: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (V,) how much of a patch each vertex shows.

        flat : (V, 2) cm, picture axes; the first D are contours.ALL
        """
        return self.falloff(np.asarray(cKDTree(flat[contours.landmark_rows(self.centre_landmarks)]).query(flat)[0]))

    def falloff(self, distance: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return how much of a patch is shown at a distance, cm, from the core."""
        return smoothstep((self.falloff_cm[1] - distance) / (self.falloff_cm[1] - self.falloff_cm[0]))

    def near(self, flat: NDArray[np.float64], falloff_cm: float, /) -> NDArray[np.bool_]:
        """Return (V,) whether each vertex lies within `reach` cm of the core."""
        return np.asarray(cKDTree(flat[contours.landmark_rows(self.centre_landmarks)]).query(flat)[0] <= falloff_cm)

    def quantised_descriptor(self, displacements: Displacements, /) -> NDArray[np.int8]:
        """Return the keys as they travel, (k,) int8."""
        return np.clip(np.rint(np.array(self.descriptor(displacements)) / DESCRIPTOR_STEP), -127, 127).astype(np.int8)


def _mouth(d: Displacements) -> list[float]:
    at = _at(d)
    return [
        at("inner_lip_upper_mid", 1) - at("inner_lip_lower_mid", 1),
        sum(at(f"inner_lip_upper_{s}", 1) - at(f"inner_lip_lower_{s}", 1) for s in "lr") / 2,
        at("outer_lip_corner_l", 0) - at("outer_lip_corner_r", 0),
        (at("outer_lip_corner_l", 1) + at("outer_lip_corner_r", 1)) / 2,
        at("outer_lip_upper_mid", 1),
        at("outer_lip_lower_mid", 1),
        at("outer_lip_upper_mid", 0) + at("outer_lip_lower_mid", 0),
    ]  # fmt: skip


def _eyes(d: Displacements) -> list[float]:
    at = _at(d)
    lids = [at(f"eyelid_upper_{s}", 1) - at(f"eyelid_lower_{s}", 1) for s in "lr"]
    return [
        lids[0] / 4,  # 1024 units are a whole blink
        lids[1] / 4,
        (at("pupil_l", 0) + at("pupil_r", 0)) * 1.5,
        (at("pupil_l", 1) + at("pupil_r", 1)) * 1.5,
        (at("brow_inner_l", 1) + at("brow_inner_r", 1)) / 3,
        (at("brow_top_l", 1) + at("brow_top_r", 1)) / 3,
    ]


def _at(d: Displacements) -> Callable[[str, int], float]:
    return lambda name, axis: float(d[CONTROL_POINT_INDEX[name], axis])


MOUTH = PatchRegion(
    "mouth",
    tuple(control_point_indices("inner_lip", "outer_lip", "cupids_bow", "chin_boss", "nose_bottom")),
    contours.UPPER_OUTER_LIP + contours.LOWER_OUTER_LIP + contours.UPPER_INNER_LIP + contours.LOWER_INNER_LIP,
    (0.4, 1.5),
    _mouth,
)
EYES = PatchRegion(
    "eyes",
    tuple(control_point_indices("eyelid", "pupil", "eye_", "brow")),
    contours.UPPER_LID_R + contours.LOWER_LID_R + contours.UPPER_LID_L + contours.LOWER_LID_L,
    (0.5, 1.4),
    _eyes,
)
FEATURES = (MOUTH, EYES)  # a patch's region is an index into them
