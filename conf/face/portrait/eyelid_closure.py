"""Eyes in a photo that can close: the upper lid's skin slides over the eyeball.

The area between the lids has vertices of its own along the upper lid's edge (the rim) and is drawn before the skin. A
lid that closes covers it and does not compress it. The control points give the motion of the lid's middle and of the
pupil: the whole edge closes in proportion to its middle. The eyeball follows the interpolated motion of the control
points while the eye is open, so that the gaze can move, and stays as photographed while the eye is closed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.lip_lid_gaps import OPENINGS, Opening, height_at

EYES = OPENINGS[1:]
OPEN_RATIO = 0.8  # of the photo's gap: above it the eyeball follows the interpolated motion
CLOSED_RATIO = 0.5  # below it the eyeball stays as photographed


@dataclass(frozen=True)
class EyeOpening:
    """The vertices of one eye in the photo.

    upper, lower : rows of the lids' edges, from corner to corner
    rim : rows of the vertices that bound the eyeball at the upper edge, without corners
    photo : the opening in the photo
    inside : (k,) rows of the vertices between the lids
    arc_position : (k,) their coordinates along the opening
    ratios : (k,) their heights above the lower edge, of the gap
    gaps : (len(rim),) between the lids below the rim, of the opening's length
    """

    upper: list[int]
    lower: list[int]
    rim: list[int]
    photo: Opening
    inside: NDArray[np.intp]
    arc_position: NDArray[np.float64]
    ratios: NDArray[np.float64]
    gaps: NDArray[np.float64]

    def apply(self, positions: NDArray[np.float64]) -> None:
        """Move edge, rim and eyeball in positions (V, 2), in place, after the lids have moved."""
        opening = Opening.between(positions[self.upper], positions[self.lower])
        x, height = opening.upper[1:-1].T
        gaps = (height - height_at(opening.lower, x)) / opening.length
        step = opening.length * opening.up
        middle = len(gaps) // 2  # the edge's middle landmark is the control point
        openness = max(float(gaps[middle]), 0.0) / float(self.gaps[middle])
        edge = np.minimum(gaps, openness * self.gaps) if openness < 1 else gaps
        positions[self.rim] = positions[self.upper[1:-1]] + (np.maximum(gaps, self.gaps) - gaps)[:, None] * step
        positions[self.upper[1:-1]] += (edge - gaps)[:, None] * step
        self._restore_inside(positions, float(np.clip((OPEN_RATIO - openness) / (OPEN_RATIO - CLOSED_RATIO), 0, 1)))

    def _restore_inside(self, positions: NDArray[np.float64], weight: float) -> None:
        """Blend the eyeball's vertices with their photographed positions between lower edge and rim."""
        if weight == 0 or not len(self.inside):
            return
        ends = [self.upper[0], *self.rim, self.upper[-1]]
        low = _points_on_edge(positions[self.lower], self.photo.lower[:, 0], self.arc_position)
        high = _points_on_edge(positions[ends], self.photo.upper[:, 0], self.arc_position)
        photographed = low + self.ratios[:, None] * (high - low)
        positions[self.inside] += weight * (photographed - positions[self.inside])


def split_eye_openings(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], /
) -> tuple[NDArray[np.float64], NDArray[np.int32], tuple[EyeOpening, ...]]:
    """Give the eyes of a photo's mesh their own rims.

    positions : (V, 2); triangles : (F, 3)
    Returns positions with the rims added, triangles with those of the eyes first (they are drawn first), and the eyes.
    """
    eyes: list[EyeOpening] = []
    eye_triangles: list[NDArray[np.int32]] = []
    centres = positions[triangles].mean(axis=1)
    for upper, lower in EYES:
        opening = Opening.between(positions[upper], positions[lower])
        between = opening.contains(positions)
        between[upper + lower] = False
        inside = np.flatnonzero(between)
        in_eye = np.isin(triangles, [*upper, *lower, *inside]).all(axis=1) & opening.contains(centres)
        rim = [len(positions) + i for i in range(len(upper) - 2)]
        new_rows = np.arange(len(positions))
        new_rows[upper[1:-1]] = rim
        eye_triangles.append(new_rows[triangles[in_eye]].astype(np.int32))
        positions = np.concatenate([positions, positions[upper[1:-1]]])
        triangles, centres = triangles[~in_eye], centres[~in_eye]
        x, height = opening.coordinates(positions[inside])
        low, high = height_at(opening.lower, x), height_at(opening.upper, x)
        gaps = (opening.upper[:, 1] - height_at(opening.lower, opening.upper[:, 0]))[1:-1] / opening.length
        ratios = (height - low) / (high - low)
        eyes.append(EyeOpening(upper, lower, rim, opening, inside, x, ratios, np.maximum(gaps, 1e-3)))
    return positions, np.concatenate([*eye_triangles, triangles]), tuple(eyes)


def _points_on_edge(
    edge: NDArray[np.float64], photo_x: NDArray[np.float64], x: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the points (k, 2) of an edge (m, 2) that had the coordinates x (k,) along it in the photo."""
    order = np.argsort(photo_x)
    return np.column_stack([np.interp(x, photo_x[order], edge[order, axis]) for axis in (0, 1)])
