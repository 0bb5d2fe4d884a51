"""A frame as both sides keep it: whole numbers, equal to the last bit on every machine."""

from dataclasses import dataclass, field

POSE_VALUES = 6
LOG_SCALE, ROTATION, FACE_CENTRE = 0, slice(1, 4), slice(4, 6)

PointResidual = tuple[int, int, int]


@dataclass(frozen=True)
class QuantisedFrame:
    """One coded frame, in steps of its profile.

    values : log scale, rotation (3), the face's middle (2), then the components of the learned space
    corrections : x, y, z of the points that the learned space does not reach, by point
    staggered : the values count from half a step further, see conf/protocol/codec/transform.py
    """

    values: tuple[int, ...]
    staggered: bool = False
    residuals: dict[int, PointResidual] = field(default_factory=dict)
