"""Estimate the neutral pose: the control points of a face without expression, without asking the person for it.

Strategy: nobody holds still at the start of a call, and the average of talking is an open mouth. So what its
blendshapes explain is subtracted from each frame (expression_offsets.py), and what is left is weighted, region by
region, by how inactive they are: a talker's brows are neutral before the mouth. The tracker hardly sees a frown, so
brows count as inactive only while no other part of the face cries, laughs or squints. The mean face is the prior,
with a very small weight: a pose that drifts away from it would be drawn as movement. Some faces never look inactive,
their brows are simply high: the prior and the required weight fall as it becomes clear that a region gets no less
active. A mouth slightly open in the least active frames is closed, and nearly shut lids are opened, because a neutral
mouth is shut and neutral eyes are open. Pupils are averaged relative to the corners of their eye, as they are sent.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    EYE_CORNERS,
    LOWER_LIP,
    PUPILS,
    control_point_indices,
)
from conf.sender.motion.expression_offsets import expression_offsets
from conf.sender.motion.eye_openness import UPPER, lid_gaps
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

PRIOR_S = 0.02  # weight of the mean face, in seconds without activity
KNOWN_S = 0.3  # seconds without activity after which a region is known
MEMORY_S = 30.0  # seconds without activity that are remembered: light, glasses and posture change
FLOOR_TIME_CONSTANT_S = 2.0  # until the lowest activity so far is accepted as the floor
MAX_FLOOR = 0.3  # brows may be this high permanently; an eye kept shut, a lasting smile are no neutral pose
BLEND_S = 0.25  # time constant with which the pose in use follows the estimate, so that nothing jumps
ACTIVITY_SCALE = 0.4  # a blendshape this strong lowers a frame's weight to 1/e
TURN_SCALE = float(np.radians(36))  # so does a head turned this far
MAX_STEP_S = 0.2  # weight of a frame after a pause
LIP_GAP_CM = 0.05  # between the inner lip landmarks of a shut mouth, measured on the clips
MIN_LID_GAP_CM = 0.4  # narrower eyes are closing
CHIN_RATIO = 0.7  # movement of the chin over that of the lower lip

# Control points that become active together, and the blendshapes that show it.
_REGION_SHAPES = {
    ("inner_lip", "outer_lip", "cupids_bow", "chin", "cheek", "nose", "nostril"): """
        jawOpen jawLeft jawRight mouthFunnel mouthPucker mouthLeft mouthRight mouthSmileLeft mouthSmileRight
        mouthFrownLeft mouthFrownRight mouthStretchLeft mouthStretchRight mouthUpperUpLeft mouthUpperUpRight
        mouthLowerDownLeft mouthLowerDownRight""",
    ("brow",): """
        browDownLeft browDownRight browInnerUp browOuterUpLeft browOuterUpRight
        eyeBlinkLeft eyeBlinkRight mouthSmileLeft mouthSmileRight""",
    ("eyelid", "eye_upper", "eye_lower"): """
        eyeBlinkLeft eyeBlinkRight eyeWideLeft eyeWideRight eyeLookUpLeft eyeLookDownLeft
        mouthSmileLeft mouthSmileRight""",
    ("pupil",): "eyeBlinkLeft eyeBlinkRight eyeLookUpLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft",
    ("eye_inner", "eye_outer"): "eyeBlinkLeft eyeBlinkRight",
}
REGIONS = [control_point_indices(*prefixes) for prefixes in _REGION_SHAPES]
_SHAPES = [[SHAPE[name] for name in names.split()] for names in _REGION_SHAPES.values()]
# Narrow eyes have a constant squint of up to 0.5: only what exceeds the person's least is activity, of these regions.
_SQUINTS = [SHAPE["eyeSquintLeft"], SHAPE["eyeSquintRight"]]
_SQUINTING = [float(prefixes[0] in ("brow", "eyelid")) for prefixes in _REGION_SHAPES]
_REGION_OF = np.zeros(CONTROL_POINT_COUNT, dtype=np.intp)
for _region, _points in enumerate(REGIONS):
    _REGION_OF[_points] = _region


class NeutralPoseEstimator:
    """An estimate of one person's neutral pose that improves with every frame."""

    def __init__(self, explain: Callable[[NDArray[np.floating]], NDArray[np.float64]] = expression_offsets, /) -> None:
        """explain : blendshapes (52,) -> offsets (n, 3) of the control points, cm, pupils relative to their eye"""
        self._explain = explain
        self._points = MEAN_FACE.copy()  # in use
        self._is_set = False
        self._sums = np.zeros((CONTROL_POINT_COUNT, 3))  # weighted, of the points
        self._weights = np.zeros(len(REGIONS))  # seconds
        self._min_activity = np.full(len(REGIONS), np.inf)
        self._min_squint = np.full(len(_SQUINTS), np.inf)
        self._observed_s = 0.0
        self._updated_at: float | None = None
        self._blended_at: float | None = None

    @property
    def points(self) -> NDArray[np.float64]:
        """The neutral pose in use, (n, 3) cm in face axes."""
        return self._points

    @property
    def known(self) -> bool:
        """Whether every region is known, or the pose was set."""
        return self._is_set or bool(np.all(self._weights >= KNOWN_S * self._max_weight()))

    def set(self, points: NDArray[np.float64], /) -> None:
        """Use control points (n, 3) cm as the neutral pose from now on."""
        self._points, self._is_set = close_mouth_open_eyes(points), True

    def reset_clock(self) -> None:
        """Start new timestamps; the next blended pose is the estimate itself."""
        self._updated_at = self._blended_at = None

    def update(
        self, points: NDArray[np.float64], blendshapes: NDArray[np.floating], /, *, turn: float, timestamp: float
    ) -> None:
        """Learn from a frame.

        points : (n, 3) cm in face axes, head pose removed
        blendshapes : (52,) 0 to 1
        turn : radians between the head's direction and the camera
        timestamp : seconds, rising
        """
        elapsed = MAX_STEP_S
        if self._updated_at is not None:
            elapsed = min(max(timestamp - self._updated_at, 0.0), MAX_STEP_S)
        self._updated_at = timestamp
        self._min_squint = np.minimum(self._min_squint, blendshapes[_SQUINTS])
        squint = float((blendshapes[_SQUINTS] - self._min_squint).max())
        activity = np.array([blendshapes[shapes].max() for shapes in _SHAPES], np.float64)
        activity = np.maximum(activity, np.multiply(_SQUINTING, squint))
        activity += ACTIVITY_SCALE * (turn / TURN_SCALE) ** 2
        self._min_activity = np.minimum(self._min_activity, activity)
        self._observed_s += elapsed
        weights = elapsed * np.exp(-activity / ACTIVITY_SCALE)
        max_weights = MEMORY_S * np.exp(-np.minimum(self._min_activity, MAX_FLOOR) / ACTIVITY_SCALE)
        keep = np.minimum(1.0, max_weights / (self._weights + weights))
        self._weights = (self._weights + weights) * keep
        neutral = close_mouth_open_eyes(relative_pupils(points) - self._explain(blendshapes))
        self._sums = (self._sums + weights[_REGION_OF, None] * neutral) * keep[_REGION_OF, None]

    def blended(self, timestamp: float, /) -> NDArray[np.float64]:
        """Return the neutral pose to use at a time, (n, 3) cm: it follows the estimate without a jump."""
        if self._is_set:
            return self._points
        alpha = 1.0
        if self._blended_at is not None:
            alpha = 1 - np.exp(-max(timestamp - self._blended_at, 0.0) / BLEND_S)
        self._blended_at = timestamp
        prior = (PRIOR_S * self._max_weight())[_REGION_OF, None]
        estimate = (prior * _RELATIVE_MEAN_FACE + self._sums) / (prior + self._weights[_REGION_OF, None])
        estimate[_PUPILS] += estimate[_CORNERS].mean(axis=1)
        self._points = self._points + alpha * (estimate - self._points)
        return self._points

    def _max_weight(self) -> NDArray[np.float64]:
        """Return, by region, the weight of a second in which this face is as inactive as it is believed to get."""
        accepted = 1 - np.exp(-self._observed_s / FLOOR_TIME_CONSTANT_S)
        return np.asarray(np.exp(-np.minimum(self._min_activity, MAX_FLOOR) * accepted / ACTIVITY_SCALE))


def relative_pupils(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return control points (n, 3), pupils relative to the middle of the corners of their eye."""
    relative = points.copy()
    relative[_PUPILS] -= points[_CORNERS].mean(axis=1)
    return relative


def close_mouth_open_eyes(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return control points (n, 3) in cm with the mouth shut and the eyes open.

    The lower lip is raised until it meets the upper, and the chin follows; an upper lid is raised from the lower one.
    """
    neutral = points.copy()
    gap = points[_UPPER_INNER_LIP, 1] - points[_LOWER_INNER_LIP, 1]
    neutral[_LOWER_INNER_LIP, 1] += np.maximum(0.0, gap - LIP_GAP_CM)
    middle = CONTROL_POINT_INDEX["inner_lip_lower_mid"]
    raised = neutral[middle, 1] - points[middle, 1]
    neutral[_LOWER_OUTER_LIP, 1] += raised
    neutral[_CHIN, 1] += raised * CHIN_RATIO
    neutral[UPPER, 1] += np.maximum(0.0, MIN_LID_GAP_CM - lid_gaps(points))
    return neutral


_PUPILS, _CORNERS = np.array(PUPILS), np.array(EYE_CORNERS)
_RELATIVE_MEAN_FACE = relative_pupils(MEAN_FACE)
_UPPER_INNER_LIP = [CONTROL_POINT_INDEX[f"inner_lip_upper_{at}"] for at in ("mid", "l", "r")]
_LOWER_INNER_LIP = [CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")]
_LOWER_OUTER_LIP = [i for i in LOWER_LIP if i not in _LOWER_INNER_LIP]
_CHIN = control_point_indices("chin")
