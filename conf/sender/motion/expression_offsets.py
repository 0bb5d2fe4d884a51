"""Predict how far an expression moves the control points, from the tracker's blendshape weights.

Strategy. A neutral pose that is learned only from quiet frames arrives late, and while it drifts from the mean face to
the person's own, the drift is drawn as movement. What the weights of a frame explain is subtracted from its points
instead, so that a frame with an expression shows the neutral pose as well. The weights of a quiet face are not 0 and
differ between people: only the difference from those of a typical quiet face counts. Learned by
tools/train/expression.py.
"""

from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT


@cache
def _load_map() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (52, 3 n) linear map, cm, and the (52,) weights of a quiet face."""
    with (files("conf.assets") / "expression.npz").open("rb") as file, np.load(file) as arrays:
        return arrays["map"].astype(np.float64), arrays["quiet"].astype(np.float64)


def expression_offsets(blendshapes: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the offsets (n, 3), cm in face axes, of the control points from those of a quiet face.

    blendshapes : (52,) 0 to 1, in the order of the tracker's network
    Pupils are relative to the middle of the corners of their eye, brows as in brow_reference.py.
    """
    weights, quiet = _load_map()
    return np.asarray(((blendshapes - quiet) @ weights).reshape(CONTROL_POINT_COUNT, 3))
