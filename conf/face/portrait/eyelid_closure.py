"""Eyes in a photograph that can shut: the lids' skin slides over what lies between them, as over an eyeball.

Between the lids lies a mesh of its own. It shares no vertex with the upper lid's edge and is drawn before the skin, so
a lid that comes down covers it and nothing is pressed flat. The fifty points say where the middle of a lid and the
pupils go: the whole edge shuts as far as its middle does; what is between follows the field of the points while the eye
is open, so that a gaze can wander, and stays as photographed while it is not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.lip_lid_gaps import OPENINGS, Opening, height_of

EYES = OPENINGS[1:]
OPEN_RATIO = 0.8  # of the photograph's gap: with more the field moves what lies between
CLOSED_RATIO = 0.5  # with less it stays as photographed


@dataclass(frozen=True)
class EyeOpening:
    """The vertices of one eye, as the photograph has them.

    upper, lower : rows of the lids' edges, from corner to corner
    rim : rows of the vertices that end the eyeball where the upper edge lies, corners left out
    photo : the slit in the photograph
    inside : rows of the vertices between
    along : (k,) how far along the slit each of them lies; shares : (k,) of the gap that is below it
    gaps : (len(rim),) between the lids below the rim, as a share of the slit's length
    """

    upper: list[int]
    lower: list[int]
    rim: list[int]
    photo: Opening
    inside: NDArray[np.intp]
    arc_position: NDArray[np.float64]
    shares: NDArray[np.float64]
    gaps: NDArray[np.float64]

    def apply(self, places: NDArray[np.float64]) -> None:
        """Move edge, rim and inside, in places (V, 2) whose lids have moved, to where they belong."""
        slit = Opening.between(places[self.upper], places[self.lower])
        at, height = slit.upper[1:-1].T
        gaps = (height - height_of(slit.lower, at)) / slit.length
        middle = len(gaps) // 2  # the edge's middle landmark is the control point
        openness = max(float(gaps[middle]), 0.0) / float(self.gaps[middle])
        edge = np.minimum(gaps, openness * self.gaps) if openness < 1 else gaps
        places[self.rim] = places[self.upper[1:-1]] + (np.maximum(gaps, self.gaps) - gaps)[:, None] * slit.step
        places[self.upper[1:-1]] += (edge - gaps)[:, None] * slit.step
        self._keep_inside(places, float(np.clip((OPEN_RATIO - openness) / (OPEN_RATIO - CLOSED_RATIO), 0, 1)))

    def _keep_inside(self, places: NDArray[np.float64], bound: float) -> None:
        """Bring what is inside nearer to its photographed place between lower edge and rim, wholly if bound is 1."""
        if bound == 0 or not len(self.inside):
            return
        ends = [self.upper[0], *self.rim, self.upper[-1]]
        low = _along_edge(places[self.lower], self.photo.lower[:, 0], self.arc_position)
        high = _along_edge(places[ends], self.photo.upper[:, 0], self.arc_position)
        between = low + self.shares[:, None] * (high - low)
        places[self.inside] += bound * (between - places[self.inside])


def split_eye_openings(
    places: NDArray[np.float64], triangles: NDArray[np.int32], /
) -> tuple[NDArray[np.float64], NDArray[np.int32], tuple[EyeOpening, ...]]:
    """Give the eyes of a photograph's mesh their own rim.

    places : (V, 2), the first D are contours.ALL; triangles : (F, 3)
    Returns places with the rims added, triangles with the eyeballs' first, so that they are drawn first, and the eyes.
    """
    found: list[EyeOpening] = []
    first: list[NDArray[np.int32]] = []
    middles = places[triangles].mean(axis=1)
    for upper, lower in EYES:
        slit = Opening.between(places[upper], places[lower])
        between = slit.contains(places)
        between[upper + lower] = False
        inside = np.flatnonzero(between)
        eye = np.isin(triangles, [*upper, *lower, *inside]).all(axis=1) & slit.contains(middles)
        rim = [len(places) + i for i in range(len(upper) - 2)]
        renamed = np.arange(len(places))
        renamed[upper[1:-1]] = rim
        first.append(renamed[triangles[eye]].astype(np.int32))
        places = np.concatenate([places, places[upper[1:-1]]])
        triangles, middles = triangles[~eye], middles[~eye]
        found.append(_eyeball(places, upper, lower, rim, inside))
    return places, np.concatenate([*first, triangles]), tuple(found)


def _eyeball(
    places: NDArray[np.float64], upper: list[int], lower: list[int], rim: list[int], inside: NDArray[np.intp]
) -> EyeOpening:
    slit = Opening.between(places[upper], places[lower])
    along, height = (places[inside] - slit.origin) @ slit.along, (places[inside] - slit.origin) @ slit.up
    low, high = height_of(slit.lower, along), height_of(slit.upper, along)
    gaps = (slit.upper[:, 1] - height_of(slit.lower, slit.upper[:, 0]))[1:-1] / slit.length
    return EyeOpening(upper, lower, rim, slit, inside, along, (height - low) / (high - low), np.maximum(gaps, 1e-3))


def _along_edge(
    edge: NDArray[np.float64], photo_at: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the places (k, 2) on an edge (m, 2) that were so far along it in the photograph."""
    order = np.argsort(photo_at)
    return np.column_stack([np.interp(at, photo_at[order], edge[order, axis]) for axis in (0, 1)])
