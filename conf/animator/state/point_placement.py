"""Placing the fifty control points by hand: what is placed, what is next, what mirrors what. No window in here."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.symmetry import MIRROR_INDICES

MIDDLE_POINTS = [point.index for point in CONTROL_POINTS if MIRROR_INDICES[point.index] == point.index]
UNDO_STEPS = 100


def _nowhere() -> NDArray[np.float64]:
    return np.full((CONTROL_POINT_COUNT, 3), np.nan)


@dataclass(frozen=True)
class PointPlacement:
    """Where the points are so far. Every change gives a new one.

    positions : (n, 3) model frame, nan for a point that is not placed yet
    selected : the point that the next click places
    mirror : whether a point of one side takes its partner with it
    history : what stood before, newest last
    """

    points: NDArray[np.float64] = field(default_factory=_nowhere)
    selected: int = 0
    mirror: bool = True
    history: tuple[NDArray[np.float64], ...] = ()

    @property
    def placed(self) -> NDArray[np.bool_]:
        """(n,) which points have a place."""
        return np.isfinite(self.points[:, 0])

    @property
    def missing(self) -> int:
        """How many points have no place yet."""
        return int((~self.placed).sum())

    def select(self, point: int) -> "PointPlacement":
        """Choose the point that the next click places."""
        return replace(self, selected=point)

    def set_point(
        self, point: int, place: NDArray[np.float64], mirrored: NDArray[np.float64] | None = None
    ) -> "PointPlacement":
        """Give a point its place, (3,), and its partner another if one is given: no step of undo of its own."""
        positions = self.points.copy()
        positions[point] = place
        partner = MIRROR_INDICES[point]
        if mirrored is not None and partner != point:
            positions[partner] = mirrored
        return replace(self, points=positions)

    def push_undo(self) -> "PointPlacement":
        """Take down how things stand: `undo` comes back here."""
        return replace(self, history=(*self.history, self.points)[-UNDO_STEPS:])

    def undo(self) -> "PointPlacement":
        """Go back to what was remembered last."""
        if not self.history:
            return self
        return replace(self, points=self.history[-1], history=self.history[:-1])

    def advance(self) -> "PointPlacement":
        """Choose the next point without a place; the same one if there is none."""
        ahead = np.roll(np.arange(CONTROL_POINT_COUNT), -self.selected - 1)
        free = ahead[~self.placed[ahead]]
        return replace(self, selected=int(free[0])) if len(free) else self

    def middle(self, otherwise: float) -> float:
        """Return the x of the plane of symmetry: that of the middle points, or `otherwise` while there are none."""
        known = [i for i in MIDDLE_POINTS if self.placed[i]]
        return float(self.points[known, 0].mean()) if known else otherwise


def swapped_pairs(placing: PointPlacement) -> list[tuple[int, int]]:
    """Return the pairs, left and right, whose left point does not lie to the subject's left of its partner."""
    pairs = [(point, MIRROR_INDICES[point]) for point in left_points(placing) if placing.placed[MIRROR_INDICES[point]]]
    return [(left, right) for left, right in pairs if placing.points[left, 0] <= placing.points[right, 0]]


def left_points(placing: PointPlacement) -> list[int]:
    """Return the placed points of the subject's left side."""
    return [p.index for p in CONTROL_POINTS if p.name.endswith("_l") and placing.placed[p.index]]


def mirror_point(place: NDArray[np.float64], middle: float) -> NDArray[np.float64]:
    """Return the place, (3,), seen in a mirror at x = middle."""
    return np.array([2 * middle - place[0], place[1], place[2]])
