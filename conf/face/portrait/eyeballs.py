"""What lies between the lids of a photograph: pressed together as the lids meet, so that eyes can shut.

The fifty points say where the middle of a lid and the pupils go, not the rest of the lid's edge, nor what becomes of
the white between. The whole edge shuts as far as its middle does. What is inside follows the field of the points while
the eye is open, so that a gaze can wander; the nearer the lids, the more it keeps its place between the two edges.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.parting import FACING, Slit, height_of

EYES = FACING[1:]
FREE = 0.7  # of the photograph's gap: with more there is room for the field to move things
BOUND = 0.3  # with less, all keep their place between the edges


@dataclass(frozen=True)
class Eyeball:
    """The vertices between the lids of one eye, as the photograph has them.

    upper, lower : rows of the lids' edges, from corner to corner
    photo : the slit in the photograph
    inside : rows of the vertices between
    along : (k,) how far along the slit each of them lies; shares : (k,) of the gap that is below it
    edge_gaps : (len(upper) - 2,) between the lids below the upper edge's vertices, as a share of the slit's length
    """

    upper: list[int]
    lower: list[int]
    photo: Slit
    inside: NDArray[np.intp]
    along: NDArray[np.float64]
    shares: NDArray[np.float64]
    edge_gaps: NDArray[np.float64]

    def follow(self, places: NDArray[np.float64]) -> None:
        """Move edge and inside, in places (V, 2) whose lids have moved, to where they belong."""
        openness = self._shut_edge(places)
        bound = float(np.clip((FREE - openness) / (FREE - BOUND), 0, 1))
        if bound > 0 and len(self.inside):
            low = _along_edge(places[self.lower], self.photo.lower[:, 0], self.along)
            high = _along_edge(places[self.upper], self.photo.upper[:, 0], self.along)
            between = low + self.shares[:, None] * (high - low)
            places[self.inside] += bound * (between - places[self.inside])

    def _shut_edge(self, places: NDArray[np.float64]) -> float:
        """Bring the upper edge down as far as its middle has come; return how open the eye is, 1 as photographed."""
        slit = Slit.between(places[self.upper], places[self.lower])
        at, height = slit.upper[1:-1].T
        gaps = (height - height_of(slit.lower, at)) / slit.length
        middle = len(gaps) // 2  # the edge's middle landmark is the control point
        openness = max(float(gaps[middle]), 0.0) / float(self.edge_gaps[middle])
        if openness < 1:
            too_high = np.maximum(0.0, gaps - openness * self.edge_gaps)
            places[self.upper[1:-1]] -= (too_high * slit.length)[:, None] * slit.up
        return openness


def find_eyeballs(places: NDArray[np.float64], /) -> list[Eyeball]:
    """Find what lies between the lids in a photograph's mesh (V, 2), whose first D vertices are contours.ALL."""
    found = []
    for upper, lower in EYES:
        slit = Slit.between(places[upper], places[lower])
        at, height = (places - slit.origin) @ slit.along, (places - slit.origin) @ slit.up
        low, high = height_of(slit.lower, at), height_of(slit.upper, at)
        between = (at > 0) & (at < slit.length) & (height > low) & (height < high)
        between[upper + lower] = False
        inside = np.flatnonzero(between)
        shares = (height[inside] - low[inside]) / (high[inside] - low[inside])
        edge = (slit.upper[:, 1] - height_of(slit.lower, slit.upper[:, 0]))[1:-1] / slit.length
        found.append(Eyeball(upper, lower, slit, inside, at[inside], shares, np.maximum(edge, 1e-3)))
    return found


def _along_edge(
    edge: NDArray[np.float64], photo_at: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the places (k, 2) on an edge (m, 2) that were so far along it in the photograph."""
    order = np.argsort(photo_at)
    return np.column_stack([np.interp(at, photo_at[order], edge[order, axis]) for axis in (0, 1)])
