"""The furrows of a drawn face: how far they pull the brows, and how deep they fold the skin.

Strategy. Landmarks hardly show a frown that folds the skin, so the sender measures the furrows between the brows in the
image. Where it sends any, the brows are knit and lowered as far as such furrows need, if the landmarks have not moved
them that far already. Brows that are raised stay raised: grief knits them too. Furrows across the forehead follow from
the brows alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import control_point_indices
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.face.interpolation import smoothstep

_UNITS_PER_CM = UNITS_PER_DISTANCE / 5.0  # of a brow: its unit is that of ens0, 5 cm on a mean face
KNIT = 0.32 * _UNITS_PER_CM  # of each inner brow towards the middle, by furrows of full depth
LOWERING = 0.22 * _UNITS_PER_CM  # of the inner brows
TOP_KNIT, TOP_LOWERING = 0.35, 0.6  # of the tops of the brows, relative
RAISED = 0.25 * _UNITS_PER_CM  # brows raised so far are not lowered
FOREHEAD_BEGIN, FOREHEAD_END = 0.35 * _UNITS_PER_CM, 1.1 * _UNITS_PER_CM  # raise of brows that folds the forehead
FOREHEAD_DEPTH = 0.6  # foreheads fold less than they can: many are young

_X, _Y = 0, 1
_INNER, _TOP = control_point_indices("brow_inner"), control_point_indices("brow_top")
_INWARDS = np.array([-1.0, 1.0], np.float32)  # of the left and the right brow


@dataclass(frozen=True)
class SkinFurrows:
    """How deep the skin is folded, 0 to 1.

    between_brows : vertical furrows; forehead : those across it
    """

    between_brows: float = 0.0
    forehead: float = 0.0


SMOOTH_SKIN = SkinFurrows()


def knit_brows(displacements: NDArray[np.float32], furrow: float, /) -> NDArray[np.float32]:
    """Return displacements (n, 3), FAPU units, whose brows are at least as knit and low as the furrows need.

    furrow : depth of the furrows between the brows, 0 to 1; 0 changes nothing
    """
    if furrow <= 0:
        return displacements
    knit = float((displacements[_INNER, _X] * _INWARDS).mean())
    raised = float(displacements[_INNER, _Y].mean())
    inwards = min(max(KNIT * furrow - knit, 0.0), KNIT)
    down = min(max(LOWERING * furrow + raised, 0.0), LOWERING * furrow) * (1 - float(smoothstep(raised / RAISED)))
    moved = displacements.copy()
    for points, knitting, lowering in ((_INNER, 1.0, 1.0), (_TOP, TOP_KNIT, TOP_LOWERING)):
        moved[points, _X] += np.float32(knitting * inwards) * _INWARDS
        moved[points, _Y] -= np.float32(lowering * down)
    return moved


def skin_furrows(displacements: NDArray[np.float32] | None, furrow: float, /) -> SkinFurrows:
    """Return how deep the skin of a drawn face is folded.

    displacements : (n, 3) FAPU units, None for the neutral face
    furrow : depth of the furrows between the brows, 0 to 1
    """
    if displacements is None:
        return SMOOTH_SKIN
    raised = float(displacements[[*_INNER, *_TOP], _Y].mean())
    forehead = float(smoothstep((raised - FOREHEAD_BEGIN) / (FOREHEAD_END - FOREHEAD_BEGIN)))
    return SkinFurrows(min(max(furrow, 0.0), 1.0), FOREHEAD_DEPTH * forehead)
