"""Find the neutral pose: where a face's control points are when it does nothing, without asking for it.

Strategy: nobody sits still for a photograph at the start of a call, and the average of talking is an open mouth. So
each frame counts, region by region, by how quiet the blendshapes say that region is: a talker's brows are neutral long
before his mouth is. A mean face stands in with the weight of a moment. Some faces never look quiet, their brows simply
lie high: the mean face loses its weight as it becomes plain that a face gets no quieter. A mouth a little open in the
quietest frames is shut by hand, because a neutral mouth is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX, LOWER_LIP, indices
from conf.sender.blendshapes import INDEX as SHAPE
from conf.sender.mean_face import MEAN_FACE

MEAN_FACE_S = 0.15  # the mean face counts as this many seconds of perfect quiet
ENOUGH_S = 0.3  # seconds of quiet after which a region is known
MEMORY_S = 30.0  # seconds of quiet that are remembered: light, glasses and posture change
PATIENCE_S = 3.0  # how long it takes to believe that a face gets no quieter than it has been
BLEND_S = 0.25  # the neutral pose in use follows the estimate this slowly, so that nothing jumps
QUIET = 0.1  # a shape this strong makes a frame count 1/e
FRONTAL = np.radians(20)  # so does a head turned this far
MAX_STEP_S = 0.2  # a pause between frames is not a long look
LIP_GAP_CM = 0.05  # between the inner lip landmarks of a shut mouth, seen on the clips
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
        indices("inner_lip", "outer_lip", "cupids_bow", "chin", "cheek", "nose", "nostril"),
        """jawOpen jawLeft jawRight mouthFunnel mouthPucker mouthLeft mouthRight mouthSmileLeft mouthSmileRight
        mouthFrownLeft mouthFrownRight mouthStretchLeft mouthStretchRight mouthUpperUpLeft mouthUpperUpRight
        mouthLowerDownLeft mouthLowerDownRight""",
    ),
    _region(indices("brow"), "browDownLeft browDownRight browInnerUp browOuterUpLeft browOuterUpRight"),
    _region(
        indices("eyelid", "eye_upper", "eye_lower"),
        "eyeBlinkLeft eyeBlinkRight eyeWideLeft eyeWideRight eyeLookUpLeft eyeLookDownLeft",
    ),
    _region(
        indices("pupil"),
        "eyeBlinkLeft eyeBlinkRight eyeLookUpLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft",
    ),
    _region(indices("eye_inner", "eye_outer"), "eyeBlinkLeft eyeBlinkRight"),
)


class NeutralPose:
    """An estimate of one person's neutral pose that gets better by watching."""

    def __init__(self) -> None:
        self.points = MEAN_FACE.copy()  # (n, 3) cm in face axes, the neutral pose in use
        self._sums = np.zeros((CONTROL_POINT_COUNT, 3))  # of what was seen, weighted
        self._weights = np.zeros(CONTROL_POINT_COUNT)  # seconds of quiet
        self._least = np.full(len(REGIONS), np.inf)  # the quietest that each region has been
        self._watched = 0.0  # seconds
        self._time: float | None = None
        self._fixed: NDArray[np.float64] | None = None

    @property
    def known(self) -> bool:
        """Whether every region is known, from quiet frames or because it was told."""
        if self._fixed is not None:
            return True
        needed = [ENOUGH_S * np.exp(-floor / QUIET) for floor in self._floors()]
        return all(self._weights[region.points[0]] >= enough for region, enough in zip(REGIONS, needed, strict=True))

    def take(self, points: NDArray[np.float64], /) -> None:
        """Take (n, 3) cm as the neutral pose, at once and for good."""
        self._fixed = self.points = close_mouth(points)

    def restart(self) -> None:
        """Begin a new row of timestamps, with the best that is known in use at once."""
        self._time = None
        if self._fixed is None:
            self.points = self._estimate()

    def update(
        self, points: NDArray[np.float64], blendshapes: NDArray[np.floating], /, *, turn: float, timestamp: float
    ) -> NDArray[np.float64]:
        """Learn from a frame and return the neutral pose (n, 3) in cm.

        points : (n, 3) cm in face axes, head pose removed
        blendshapes : (52,) 0 to 1
        turn : radians, how far the head is turned from the camera
        timestamp : seconds
        """
        elapsed = 0.0 if self._time is None else min(max(timestamp - self._time, 0.0), MAX_STEP_S)
        self._time = timestamp
        if self._fixed is None:
            self._learn(points, blendshapes, turn, elapsed)
            self.points = self.points + (1 - np.exp(-elapsed / BLEND_S)) * (self._estimate() - self.points)
        return self.points

    def _learn(
        self, points: NDArray[np.float64], blendshapes: NDArray[np.floating], turn: float, elapsed: float
    ) -> None:
        shut = close_mouth(points)
        self._watched += elapsed
        for i, region in enumerate(REGIONS):
            activity = float(blendshapes[region.shapes].max()) + QUIET * (turn / FRONTAL) ** 2
            self._least[i] = min(self._least[i], activity)
            weight = elapsed * np.exp(-activity / QUIET)
            self._sums[region.points] += weight * shut[region.points]
            self._weights[region.points] += weight
            most = MEMORY_S * np.exp(-self._least[i] / QUIET)
            forget = min(1.0, most / max(self._weights[region.points[0]], 1e-300))
            self._sums[region.points] *= forget
            self._weights[region.points] *= forget

    def _floors(self) -> NDArray[np.float64]:
        """Return for each region how quiet this face is believed to get."""
        least = np.where(np.isfinite(self._least), self._least, 0.0)
        return np.asarray(least * (1 - np.exp(-self._watched / PATIENCE_S)))

    def _estimate(self) -> NDArray[np.float64]:
        prior = np.empty((CONTROL_POINT_COUNT, 1))
        for region, floor in zip(REGIONS, self._floors(), strict=True):
            prior[region.points] = MEAN_FACE_S * np.exp(-floor / QUIET)
        return np.asarray((prior * MEAN_FACE + self._sums) / (prior + self._weights[:, None]))


def close_mouth(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return control points (n, 3) in cm with the lower lip raised until the mouth is shut, and the chin after it."""
    shut = points.copy()
    for upper, lower in _FACING_LIPS:
        shut[lower, 1] += max(0.0, points[upper, 1] - points[lower, 1] - LIP_GAP_CM)
    middle = INDEX["inner_lip_lower_mid"]
    gap = shut[middle, 1] - points[middle, 1]
    shut[_OUTER_LOWER_LIP, 1] += gap
    shut[_CHIN, 1] += gap * CHIN_SHARE
    return shut


_FACING_LIPS = [(INDEX[f"inner_lip_upper_{at}"], INDEX[f"inner_lip_lower_{at}"]) for at in ("mid", "l", "r")]
_OUTER_LOWER_LIP = [i for i in LOWER_LIP if i not in [lower for _, lower in _FACING_LIPS]]
_CHIN = indices("chin")
