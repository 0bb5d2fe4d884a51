"""Find the line between the lips and the edges of the eyelids on a mesh that faces the viewer.

Strategy. A column of rays down the face gives a depth profile. Between the lips it dips, or falls into the mouth. At
the edge of a lid it jumps, or passes from the skin to an eyeball that is a component of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.raycast import cast_front_rays

# All in cm.
STEP = 0.02  # between the rays of a column
_LIP_SEARCH = 0.9  # above and below the expected line where the lips may meet
_LIP_BULGE = 0.5  # distance within which a lip bulges beside the line
_MAX_DIP = 1.0  # a deeper dip counts as a hole
_OPEN_DEPTH = 0.5  # behind the lips: anything deeper is the inside of the mouth
_DISTANCE_PENALTY = 0.15  # subtracted from the dip per cm of distance from the expected line
_MIN_DIP = 0.02  # of a line between lips
_LID_SEARCH = 0.8  # beyond the expected edge where a lid may end
_LID_JUMP = 0.06  # of depth from one ray to the next


@dataclass(frozen=True)
class DepthProfile:
    """The hits of a column of rays, from the lowest to the highest.

    heights : (S,) y; depths : (S,) z, -inf for a miss; labels : (S,) component of the triangle hit, -1 for a miss
    """

    x: float
    heights: NDArray[np.float64]
    depths: NDArray[np.float64]
    labels: NDArray[np.int32]

    def point(self, sample: int) -> NDArray[np.float64]:
        """Return the (3,) position of one sample."""
        return np.array([self.x, self.heights[sample], self.depths[sample]])


@dataclass(frozen=True)
class LabelledMesh:
    """A mesh (V, 3), (F, 3) with the label (F,) of the connected component of each triangle."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    triangle_labels: NDArray[np.int32]

    def profile(self, x: float, low: float, high: float) -> DepthProfile:
        """Cast a column of rays at x, from y low to y high."""
        heights = np.arange(low, high, STEP)
        hits = cast_front_rays(np.stack([np.full(len(heights), x), heights], axis=1), self.vertices, self.triangles)
        depths = np.where(hits.triangles < 0, -np.inf, hits.points[:, 2])
        return DepthProfile(x, heights, depths, np.where(hits.triangles < 0, -1, self.triangle_labels[hits.triangles]))


def find_lip_line(
    mesh: LabelledMesh, expected: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the lowest point of the upper lip and the highest of the lower one, (3,) each.

    expected : (3,) approximate position of the line
    Returns None if the profile does not dip there.
    """
    x, y, z = expected
    margin = _LIP_SEARCH + _LIP_BULGE
    profile = mesh.profile(x, y - margin, y + margin)
    depths = np.clip(profile.depths, z - _MAX_DIP - _OPEN_DEPTH, None)
    width = round(_LIP_BULGE / STEP)
    above = np.array([depths[i : i + width].max() for i in range(len(depths))])
    below = np.array([depths[max(0, i - width + 1) : i + 1].max() for i in range(len(depths))])
    dip = np.minimum(np.minimum(above, below) - depths, _MAX_DIP)
    score = dip - _DISTANCE_PENALTY * np.abs(profile.heights - y)
    score[np.abs(profile.heights - y) > _LIP_SEARCH] = -np.inf
    line = int(score.argmax())
    if dip[line] < _MIN_DIP:
        return None
    top = bottom = line
    if dip[line] > _OPEN_DEPTH:  # the lips are apart: walk to the two edges
        floor = min(above[line], below[line]) - _OPEN_DEPTH
        while top < len(depths) - 1 and depths[top] < floor:
            top += 1
        while bottom > 0 and depths[bottom] < floor:
            bottom -= 1
    else:
        bottom = max(line - 1, 0)  # the lower lip ends one ray below the upper
    return profile.point(top), profile.point(bottom)


def find_lid_edge(mesh: LabelledMesh, expected: NDArray[np.float64], inside: float) -> NDArray[np.float64] | None:
    """Return the (3,) edge of a lid nearest to the expected one, or None if there is none near.

    expected : (3,) approximate position of the edge
    inside : y of a position inside the open eye; the profile runs from there
    """
    x, y, _ = expected
    beyond = y + np.sign(y - inside) * _LID_SEARCH
    profile = mesh.profile(x, min(inside, beyond), max(inside, beyond))
    order = np.arange(len(profile.heights))
    if beyond < inside:
        order = order[::-1]
    depths, labels = profile.depths[order], profile.labels[order]
    with np.errstate(invalid="ignore"):
        rises = np.diff(depths) > _LID_JUMP
    onto_skin = (np.diff(labels) != 0) & (labels[1:] >= 0) | rises & np.isfinite(depths[1:])
    edges = order[np.flatnonzero(onto_skin) + 1]
    if not len(edges):
        return None
    distance = np.abs(profile.heights[edges] - y)
    return profile.point(int(edges[distance.argmin()])) if distance.min() <= _LID_SEARCH else None
