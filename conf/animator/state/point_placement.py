"""State of placing the control points by hand: positions, selection, mirroring, undo."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.symmetry import MIRROR_INDICES

MIDDLE_POINTS = [point.index for point in CONTROL_POINTS if MIRROR_INDICES[point.index] == point.index]
LEFT_POINTS = [point.index for point in CONTROL_POINTS if point.name.endswith("_l")]
UNDO_STEPS = 100


@dataclass(frozen=True)
class PointPlacement:
    """Immutable placement state.

    points : (n, 3) model frame, cm; nan for a point that is not placed
    selected : index of the point that the next click places
    mirror : whether setting a point also sets its partner on the other side
    history : earlier values of `points`, newest last
    """

    points: NDArray[np.float64] = field(default_factory=lambda: np.full((CONTROL_POINT_COUNT, 3), np.nan))
    selected: int = 0
    mirror: bool = True
    history: tuple[NDArray[np.float64], ...] = ()

    @property
    def placed(self) -> NDArray[np.bool_]:
        """(n,) which points have a position."""
        return np.isfinite(self.points[:, 0])

    @property
    def missing(self) -> int:
        """Number of points without a position."""
        return int((~self.placed).sum())

    @property
    def left_points(self) -> list[int]:
        """Placed points of the subject's left side."""
        return [point for point in LEFT_POINTS if self.placed[point]]

    @property
    def swapped_pairs(self) -> list[tuple[int, int]]:
        """Placed pairs, left and right, whose left point does not lie to the subject's left of the right one."""
        pairs = [(point, MIRROR_INDICES[point]) for point in self.left_points if self.placed[MIRROR_INDICES[point]]]
        return [(left, right) for left, right in pairs if self.points[left, 0] <= self.points[right, 0]]

    def select(self, point: int) -> "PointPlacement":
        """Select the point that the next click places."""
        return replace(self, selected=point)

    def set_point(
        self, point: int, position: NDArray[np.float64], mirrored: NDArray[np.float64] | None = None
    ) -> "PointPlacement":
        """Set a point to a (3,) position, and its partner to `mirrored` if given; adds no undo step."""
        points = self.points.copy()
        if mirrored is not None:
            points[MIRROR_INDICES[point]] = mirrored
        points[point] = position  # last: a point on the middle line is its own partner
        return replace(self, points=points)

    def push_undo(self) -> "PointPlacement":
        """Add an undo step."""
        return replace(self, history=(*self.history, self.points)[-UNDO_STEPS:])

    def undo(self) -> "PointPlacement":
        """Return to the newest undo step; unchanged if there is none."""
        return replace(self, points=self.history[-1], history=self.history[:-1]) if self.history else self

    def advance(self) -> "PointPlacement":
        """Select the next point that is not placed; unchanged if there is none."""
        following = np.roll(np.arange(CONTROL_POINT_COUNT), -self.selected - 1)
        missing = following[~self.placed[following]]
        return replace(self, selected=int(missing[0])) if len(missing) else self

    def mirrored(self, position: NDArray[np.float64], default_x: float) -> NDArray[np.float64]:
        """Return the (3,) position mirrored at the plane of symmetry.

        The plane is the mean x of the placed middle points, or `default_x` if none is placed.
        """
        placed = [point for point in MIDDLE_POINTS if self.placed[point]]
        plane = float(self.points[placed, 0].mean()) if placed else default_x
        return np.array([2 * plane - position[0], position[1], position[2]])
