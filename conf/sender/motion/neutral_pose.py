"""Find the neutral pose: where a face's control points are when it does nothing, without asking for it.

Strategy: nobody sits still for a photograph at the start of a call, and the average of talking is an open mouth. So
each frame counts, region by region, by how quiet the blendshapes say that region is: a talker's brows are neutral long
before his mouth is. A mean face stands in with the weight of a moment. Some faces never look quiet, their brows simply
lie high: the mean face loses its weight as it becomes plain that a face gets no quieter. A mouth a little open in the
quietest frames is shut by hand, and lids nearly shut are opened, because a neutral mouth is and a neutral eye is not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, LOWER_LIP, control_point_indices
from conf.sender.motion import eye_openness as lids
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

MEAN_FACE_S = 0.15  # the mean face counts as this many seconds of perfect quiet
ENOUGH_S = 0.3  # seconds of quiet after which a region is known
MEMORY_S = 30.0  # seconds of quiet that are remembered: light, glasses and posture change
FLOOR_TIME_CONSTANT_S = 2.0  # how long it takes to believe that a face gets no quieter than it has been
MAX_FLOOR = 0.3  # but brows may lie this high for good, not more: an eye kept shut, a lasting smile are no neutral pose
BLEND_S = 0.25  # the neutral pose in use follows the estimate this slowly, so that nothing jumps
ACTIVITY_SCALE = 0.12  # a shape this strong makes a frame count 1/e
FRONTAL = np.radians(20)  # so does a head turned this far
MAX_STEP_S = 0.2  # a pause between frames is not a long look
LIP_GAP_CM = 0.05  # between the inner lip landmarks of a shut mouth, seen on the clips
MIN_LID_GAP_CM = 0.4  # narrower eyes are on their way to shut
CHIN_SHARE = 0.7  # of what the lower lip moves to shut, the chin moves this much


@dataclass(frozen=True)
class Region:
    """Control points that are quiet together, and the blendshapes that say when they are not."""

    points: list[int]
    shapes: list[int]


def _region(points: list[int], shapes: str) -> Region:
    return Region(points, [SHAPE[name] for name in shapes.split()])


REGIONS = (
    _region(
        control_point_indices("inner_lip", "outer_lip", "cupids_bow", "chin", "cheek", "nose", "nostril"),
        """jawOpen jawLeft jawRight mouthFunnel mouthPucker mouthLeft mouthRight mouthSmileLeft mouthSmileRight
        mouthFrownLeft mouthFrownRight mouthStretchLeft mouthStretchRight mouthUpperUpLeft mouthUpperUpRight
        mouthLowerDownLeft mouthLowerDownRight""",
    ),
    _region(control_point_indices("brow"), "browDownLeft browDownRight browInnerUp browOuterUpLeft browOuterUpRight"),
    _region(
        control_point_indices("eyelid", "eye_upper", "eye_lower"),
        "eyeBlinkLeft eyeBlinkRight eyeWideLeft eyeWideRight eyeLookUpLeft eyeLookDownLeft",
    ),
    _region(
        control_point_indices("pupil"),
        "eyeBlinkLeft eyeBlinkRight eyeLookUpLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft",
    ),
    _region(control_point_indices("eye_inner", "eye_outer"), "eyeBlinkLeft eyeBlinkRight"),
)


class NeutralPoseEstimator:
    """An estimate of one person's neutral pose that gets better by watching."""

    def __init__(self) -> None:
        self._points = MEAN_FACE.copy()  # in use
        self._taken = False  # told, not found
        self._sums = np.zeros((CONTROL_POINT_COUNT, 3))  # of what was seen, weighted
        self._weights = np.zeros(len(REGIONS))  # seconds of quiet
        self._least = np.zeros(len(REGIONS))  # the quietest that each region has been
        self._watched = 0.0  # seconds
        self._learned_at: float | None = None
        self._blended_at: float | None = None

    @property
    def points(self) -> NDArray[np.float64]:
        """Return the neutral pose in use, (n, 3) cm in face axes."""
        return self._points

    @property
    def known(self) -> bool:
        """Whether every region is known, from quiet frames or because it was told."""
        return self._taken or bool(np.all(self._weights >= ENOUGH_S * self._best_weight()))

    def set(self, points: NDArray[np.float64], /) -> None:
        """Take control points (n, 3) cm as the neutral pose, at once and for good."""
        self._points, self._taken = close_mouth_open_eyes(points), True

    def reset_clock(self) -> None:
        """Begin a new row of timestamps, with the best that is known in use at once."""
        self._learned_at = self._blended_at = None

    def update(
        self, points: NDArray[np.float64], blendshapes: NDArray[np.floating], /, *, turn: float, timestamp: float
    ) -> None:
        """Learn from a frame.

        points : (n, 3) cm in face axes, head pose removed
        blendshapes : (52,) 0 to 1
        turn : radians, how far the head is turned from the camera
        timestamp : seconds, of the frames learned from in order
        """
        elapsed = MAX_STEP_S
        if self._learned_at is not None:
            elapsed = min(max(timestamp - self._learned_at, 0.0), MAX_STEP_S)
        self._learned_at = timestamp
        activity = (
            np.array([blendshapes[region.shapes].max() for region in REGIONS]) + ACTIVITY_SCALE * (turn / FRONTAL) ** 2
        )
        self._least = np.minimum(self._least, activity) if self._watched else activity
        self._watched += elapsed
        weights = elapsed * np.exp(-activity / ACTIVITY_SCALE)
        most = MEMORY_S * np.exp(-np.minimum(self._least, MAX_FLOOR) / ACTIVITY_SCALE)
        keep = np.minimum(1.0, most / (self._weights + weights))  # of the past, when memory is full
        self._weights = (self._weights + weights) * keep
        self._sums = (self._sums + weights[_REGION_OF, None] * close_mouth_open_eyes(points)) * keep[_REGION_OF, None]

    def blended(self, timestamp: float, /) -> NDArray[np.float64]:
        """Return the neutral pose to use at a time, (n, 3) cm: it follows what was learned without a jump."""
        if self._taken:
            return self._points
        share = 1.0  # nothing has been shown yet that could jump
        if self._blended_at is not None:
            share = 1 - np.exp(-max(timestamp - self._blended_at, 0.0) / BLEND_S)
        self._blended_at = timestamp
        self._points = self._points + share * (self._estimate() - self._points)
        return self._points

    def _best_weight(self) -> NDArray[np.float64]:
        """Return, by region, what a second weighs in which this face is as quiet as it is believed to get."""
        floor = np.minimum(self._least, MAX_FLOOR) * (1 - np.exp(-self._watched / FLOOR_TIME_CONSTANT_S))
        return np.asarray(np.exp(-floor / ACTIVITY_SCALE))

    def _estimate(self) -> NDArray[np.float64]:
        prior = (MEAN_FACE_S * self._best_weight())[_REGION_OF, None]
        return np.asarray((prior * MEAN_FACE + self._sums) / (prior + self._weights[_REGION_OF, None]))


def close_mouth_open_eyes(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return control points (n, 3) in cm with the mouth shut and the eyes open.

    The lower lip is raised until it meets the upper and the chin follows; an upper lid is raised off the lower one.
    """
    composed = points.copy()
    for upper, lower in _FACING_LIPS:
        composed[lower, 1] += max(0.0, points[upper, 1] - points[lower, 1] - LIP_GAP_CM)
    middle = CONTROL_POINT_INDEX["inner_lip_lower_mid"]
    gap = composed[middle, 1] - points[middle, 1]
    composed[_OUTER_LOWER_LIP, 1] += gap
    composed[_CHIN, 1] += gap * CHIN_SHARE
    composed[lids.UPPER, 1] += np.maximum(0.0, MIN_LID_GAP_CM - lids.lid_gaps(points))
    return composed


_FACING_LIPS = [
    (CONTROL_POINT_INDEX[f"inner_lip_upper_{blended}"], CONTROL_POINT_INDEX[f"inner_lip_lower_{blended}"])
    for blended in ("mid", "l", "r")
]
_OUTER_LOWER_LIP = [i for i in LOWER_LIP if i not in [lower for _, lower in _FACING_LIPS]]
_CHIN = control_point_indices("chin")
_REGION_OF = np.zeros(CONTROL_POINT_COUNT, dtype=np.intp)
for _number, _known in enumerate(REGIONS):
    _REGION_OF[_known.points] = _number
