"""The regions of a face that have patches: their control points, their extent and their descriptors.

A descriptor is a few numbers that describe the expression of a region, in FAPU units. Both sides of a call compute it
alike: the sender adds a patch if the descriptor is far from those of all patches sent, the receiver shows the patches
with the nearest descriptors.
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
DESCRIPTOR_STEP = 16.0  # FAPU units in one quantisation step of a descriptor


@dataclass(frozen=True)
class PatchRegion:
    """A region of the face.

    points : control points of its patches
    centre_landmarks : landmarks; a patch is opaque within falloff_cm[0] of them and transparent beyond falloff_cm[1]
    descriptor : function from displacements (n, 3) to the descriptor, FAPU units
    """

    name: str
    points: tuple[int, ...]
    centre_landmarks: tuple[int, ...]
    falloff_cm: tuple[float, float]
    descriptor: Callable[[Displacements], list[float]]

    def weights(self, positions_cm: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (V,) the opacity of a patch at each vertex."""
        return self.falloff(self._distance(positions_cm))

    def falloff(self, distance: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the opacity of a patch at distances in cm from the centre landmarks."""
        return smoothstep((self.falloff_cm[1] - distance) / (self.falloff_cm[1] - self.falloff_cm[0]))

    def near(self, positions_cm: NDArray[np.float64], distance: float, /) -> NDArray[np.bool_]:
        """Return (V,) whether each vertex is within a distance in cm of the centre landmarks."""
        return np.asarray(self._distance(positions_cm) <= distance)

    def _distance(self, positions_cm: NDArray[np.float64]) -> NDArray[np.float64]:
        centre = positions_cm[contours.landmark_rows(self.centre_landmarks)]
        return np.asarray(cKDTree(centre).query(positions_cm)[0])

    def quantised_descriptor(self, displacements: Displacements, /) -> NDArray[np.int8]:
        """Return the descriptor as it is sent, (k,) int8."""
        return np.clip(np.rint(np.array(self.descriptor(displacements)) / DESCRIPTOR_STEP), -127, 127).astype(np.int8)


def _describe_mouth(displacements: Displacements) -> list[float]:
    d = _lookup(displacements)
    return [
        d("inner_lip_upper_mid", 1) - d("inner_lip_lower_mid", 1),
        sum(d(f"inner_lip_upper_{s}", 1) - d(f"inner_lip_lower_{s}", 1) for s in "lr") / 2,
        d("outer_lip_corner_l", 0) - d("outer_lip_corner_r", 0),
        (d("outer_lip_corner_l", 1) + d("outer_lip_corner_r", 1)) / 2,
        d("outer_lip_upper_mid", 1),
        d("outer_lip_lower_mid", 1),
        d("outer_lip_upper_mid", 0) + d("outer_lip_lower_mid", 0),
    ]


def _describe_eyes(displacements: Displacements) -> list[float]:
    d = _lookup(displacements)
    return [
        *((d(f"eyelid_upper_{s}", 1) - d(f"eyelid_lower_{s}", 1)) / 4 for s in "lr"),  # a full blink is 1024 units
        (d("pupil_l", 0) + d("pupil_r", 0)) * 1.5,
        (d("pupil_l", 1) + d("pupil_r", 1)) * 1.5,
        (d("brow_inner_l", 1) + d("brow_inner_r", 1)) / 3,
        (d("brow_top_l", 1) + d("brow_top_r", 1)) / 3,
    ]


def _lookup(displacements: Displacements) -> Callable[[str, int], float]:
    return lambda name, axis: float(displacements[CONTROL_POINT_INDEX[name], axis])


MOUTH = PatchRegion(
    "mouth",
    tuple(control_point_indices("inner_lip", "outer_lip", "cupids_bow", "chin_boss", "nose_bottom")),
    contours.UPPER_OUTER_LIP + contours.LOWER_OUTER_LIP + contours.UPPER_INNER_LIP + contours.LOWER_INNER_LIP,
    (0.4, 1.5),
    _describe_mouth,
)
EYES = PatchRegion(
    "eyes",
    tuple(control_point_indices("eyelid", "pupil", "eye_", "brow")),
    contours.UPPER_LID_R + contours.LOWER_LID_R + contours.UPPER_LID_L + contours.LOWER_LID_L,
    (0.5, 1.4),
    _describe_eyes,
)
FEATURES = (MOUTH, EYES)  # a patch's region is an index into this
