"""FAPU: facial animation parameter units, in which one motion fits every face.

Displacements are transmitted in these units. The unit of each axis of each control point is 1/1024 of the distance that
governs it in the neutral face, as in MPEG-4: a wide smile of a small mouth is a wide smile of a large one.
Source: ISO/IEC 14496-2, Annex C, table of facial animation parameter units.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS, ControlPoint

UNITS_PER_DISTANCE = 1024


@dataclass(frozen=True)
class Fapu:
    """The five distances of a neutral face, in the face's length unit.

    es0 : between the pupils
    ens0 : from the eye line to the nose
    mns0 : from the nose to the mouth
    mw0 : mouth width
    irisd0 : travel of an upper lid that closes, mean of both eyes
    """

    es0: float
    ens0: float
    mns0: float
    mw0: float
    irisd0: float

    def __post_init__(self) -> None:
        if not all(math.isfinite(d) and d > 0 for d in self.distances):
            raise ValueError(f"every FAPU distance must be positive, got {self}")

    @classmethod
    def measure(cls, points: NDArray[np.floating], /, *, closed_lid_gap: float = 0.0) -> "Fapu":
        """Measure the distances of a neutral face.

        points : (n, 3) control points of the neutral face, any length unit
        closed_lid_gap : distance of the lid points of a closed eye, relative to the open eye: 0 for a rendered face,
            more for a tracker's landmarks
        Raises ValueError if a distance is not positive.
        """
        left, right = np.asarray(points, dtype=np.float64)[_MEASURED]  # (5, 3) each
        eyes, nose, mouth, *_ = ((left + right) / 2).tolist()
        (pupil_l, _, corner_l, *lids_l), (pupil_r, _, corner_r, *lids_r) = left.tolist(), right.tolist()
        return cls(
            es0=math.dist(pupil_l, pupil_r),
            ens0=math.dist(eyes, nose),
            mns0=math.dist(nose, mouth),
            mw0=math.dist(corner_l, corner_r),
            irisd0=(math.dist(*lids_l) + math.dist(*lids_r)) / 2 * (1 - closed_lid_gap),
        )

    @property
    def distances(self) -> tuple[float, float, float, float, float]:
        """The five distances, in the order of their definition."""
        return self.es0, self.ens0, self.mns0, self.mw0, self.irisd0

    def lengths(self) -> NDArray[np.float64]:
        """Return the (n, 3) length of one unit for each axis of each control point, in the face's length unit."""
        return governing(self.distances) / UNITS_PER_DISTANCE


_MEASURED_NAMES = ("pupil", "nose_bottom_edge", "outer_lip_corner", "eyelid_upper", "eyelid_lower")
_MEASURED = [[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in _MEASURED_NAMES] for side in "lr"]
_FIELDS = ("es0", "ens0", "mns0", "mw0", "irisd0")

# The distances that govern x, y and z of each feature point group; a name takes precedence over its group.
_BY_NAME = {"eyelid": ("es0", "irisd0", "es0"), "nose": ("ens0", "ens0", "ens0"), "nostril": ("ens0", "ens0", "ens0")}
_BY_GROUP = {
    "2": ("mw0", "mns0", "mw0"),  # inner lip, chin
    "3": ("es0", "es0", "es0"),  # eyes
    "4": ("ens0", "ens0", "ens0"),  # brows
    "5": ("ens0", "ens0", "ens0"),  # cheeks
    "8": ("mw0", "mns0", "mw0"),  # outer lip
}


def _governing_distances(point: ControlPoint) -> list[int]:
    axes = _BY_NAME.get(point.name.split("_")[0]) or _BY_GROUP[point.feature_point.split(".")[0]]
    return [_FIELDS.index(axis) for axis in axes]


_GOVERNING = np.array([_governing_distances(point) for point in CONTROL_POINTS])  # (n, 3) indices into _FIELDS


# Distance of the outer corners of the eyes over that of the pupils, mean of 25 people.
_EYE_WIDTH_RATIO = 1.39
_MAX_SCALE = 1.6  # either way; people need 0.9 to 1.5 on the default head
_MIN_LID_SCALE, _MAX_LID_SCALE = 0.75, 1.15  # of the head's own opening: 25 people need 0.69 to 1.06


def motion_scales(sender: Fapu, face: Fapu, eye_width: float, /) -> tuple[float, float, float, float, float]:
    """Return the factors for the lengths of a face's units, so that each part moves as far as the sender's.

    The distance from nose to mouth differs more between faces than mouths do: on a face whose nose is near its mouth,
    every opening would be too small. With these factors, one for each distance, a motion keeps its ratio to the width
    of the eyes.

    sender : FAPU of the person who moved; face : of the face that is drawn
    eye_width : of this face, between the outer corners of its eyes, in its length unit
    """
    unit = eye_width / (_EYE_WIDTH_RATIO * sender.es0)
    es0, ens0, mns0, mw0, irisd0 = (
        unit * theirs / own for theirs, own in zip(sender.distances, face.distances, strict=True)
    )
    es0, ens0, mns0, mw0 = (min(max(scale, 1 / _MAX_SCALE), _MAX_SCALE) for scale in (es0, ens0, mns0, mw0))
    return es0, ens0, mns0, mw0, min(max(irisd0, _MIN_LID_SCALE), _MAX_LID_SCALE)


def governing(distances: tuple[float, float, float, float, float], /) -> NDArray[np.float64]:
    """Return (n, 3): for each axis of each control point, the one of five values that governs it."""
    return np.asarray(np.array(distances)[_GOVERNING])
