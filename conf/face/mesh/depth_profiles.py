"""Find the line where the lips meet and the edges of the lids on a mesh that looks at the viewer.

Strategy. A column of rays down the face gives its profile. Between the lips the profile dips, or falls into the mouth;
at the edge of a lid it jumps, or passes from the skin to an eyeball that is a shell of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.raycast import cast_front_rays

STEP = 0.02  # cm between the rays of a column
_LIP_REACH = 0.9  # cm above and below the expected line that the lips may meet
_LIP_BULGE = 0.5  # cm within which a lip bulges before the line
_NO_FLOOR = 1.0  # cm: a fall deeper than this is as good as a hole
_OPEN = 0.5  # cm behind the lips: what lies deeper is the mouth's inside
_DISTANCE_PENALTY = 0.15  # how much dip a cm away from the expected line costs
_LEAST_DIP = 0.02  # cm: a shallower one is no line
_LID_REACH = 0.8  # cm beyond the expected edge that a lid may end
_LID_JUMP = 0.06  # cm in one step


@dataclass(frozen=True)
class DepthProfile:
    """What a column of rays met, from the lowest to the highest.

    heights : (S,) y; depths : (S,) z, as deep as can be where there is nothing; shells : (S,) -1 where there is nothing
    """

    x: float
    heights: NDArray[np.float64]
    depths: NDArray[np.float64]
    shells: NDArray[np.int32]

    def point(self, sample: int) -> NDArray[np.float64]:
        """Return the (3,) place of one sample."""
        return np.array([self.x, self.heights[sample], self.depths[sample]])


@dataclass(frozen=True)
class LabelledMesh:
    """A mesh and which connected part each triangle belongs to: (V, 3), (F, 3), (F,)."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    of_triangle: NDArray[np.int32]

    def profile(self, x: float, low: float, high: float) -> DepthProfile:
        """Cast a column of rays."""
        heights = np.arange(low, high, STEP)
        hits = cast_front_rays(np.stack([np.full(len(heights), x), heights], axis=1), self.vertices, self.triangles)
        depths = np.where(hits.triangles < 0, -np.inf, hits.points[:, 2])
        shells = np.where(hits.triangles < 0, -1, self.of_triangle[hits.triangles])
        return DepthProfile(x, heights, depths, shells)


def find_lip_line(
    shells: LabelledMesh, expected: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the lowest point of the upper lip and the highest of the lower one where the lips meet or part.

    expected : (3,) about where the line is; None if the profile does not dip there
    """
    x, y, z = expected
    margin = _LIP_REACH + _LIP_BULGE
    profile = shells.profile(x, y - margin, y + margin)
    depths = np.clip(profile.depths, z - _NO_FLOOR - _OPEN, None)
    width = round(_LIP_BULGE / STEP)
    above = np.array([depths[i : i + width].max() for i in range(len(depths))])
    below = np.array([depths[max(0, i - width + 1) : i + 1].max() for i in range(len(depths))])
    dip = np.minimum(np.minimum(above, below) - depths, _NO_FLOOR)
    score = dip - _DISTANCE_PENALTY * np.abs(profile.heights - y)
    score[np.abs(profile.heights - y) > _LIP_REACH] = -np.inf
    line = int(score.argmax())
    if dip[line] < _LEAST_DIP:
        return None
    top = bottom = line
    if dip[line] > _OPEN:  # apart: walk to the two edges
        floor = min(above[line], below[line]) - _OPEN
        while top < len(depths) - 1 and depths[top] < floor:
            top += 1
        while bottom > 0 and depths[bottom] < floor:
            bottom -= 1
    else:
        bottom = max(line - 1, 0)  # the lower lip's edge lies before the upper's
    return profile.point(top), profile.point(bottom)


def find_lid_edge(shells: LabelledMesh, expected: NDArray[np.float64], inside: float) -> NDArray[np.float64] | None:
    """Return the edge of a lid, (3,), walking up or down from within the eye; None if there is none near.

    expected : (3,) about where the edge is
    inside : y of a place in the open eye
    """
    x, y, _ = expected
    beyond = y + np.sign(y - inside) * _LID_REACH
    profile = shells.profile(x, min(inside, beyond), max(inside, beyond))
    order = np.arange(len(profile.heights))
    if beyond < inside:
        order = order[::-1]
    depths, shell = profile.depths[order], profile.shells[order]
    with np.errstate(invalid="ignore"):
        rises = np.diff(depths) > _LID_JUMP
    onto_skin = (np.diff(shell) != 0) & (shell[1:] >= 0) | rises & np.isfinite(depths[1:])
    edges = np.flatnonzero(onto_skin) + 1
    if not len(edges):
        return None
    nearest = edges[np.abs(profile.heights[order][edges] - y).argmin()]
    if abs(profile.heights[order][nearest] - y) > _LID_REACH:
        return None
    return profile.point(int(order[nearest]))
