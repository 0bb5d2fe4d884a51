"""Choose components that keep the curves of an expression, such as the height of a brow above the bridge of the nose.

Strategy. The components are fewer than the coordinates, so what they decode to differs from what was sent even before
rounding, and the differences of points that viewers read an expression from are small beside it. The least squares
solution under linear equality constraints decodes to the same curves, with a somewhat larger error of the points;
halfway to it curves gain most of that, and movements that the components do not know lose little. Both are folded into
the encoder's matrix: decoders need no rule, and it takes no time.
Source: Golub, Van Loan, Matrix Computations, 6.2.
"""

from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

FILE = "curves.npz"
STRENGTH = 0.5  # of the constraints: at 1 a still grimace differs from itself when decoded, and is sent again and again


@cache
def load_curves() -> NDArray[np.float64]:
    """Return the gradients (R, 3 n) of the curves, eye distances per FAPU unit, made by tools/train/curves.py."""
    with resources.files("conf.assets").joinpath(FILE).open("rb") as file, np.load(file) as arrays:
        return np.asarray(arrays["gradients"], np.float64)


def keep_curves(
    forward: NDArray[np.float64], inverse: NDArray[np.float64], curves: NDArray[np.float64], /, *, strength: float
) -> NDArray[np.float64]:
    """Return a matrix (3 n, K) to components that decode to nearly the same curves as the displacements have.

    forward : (3 n, K) displacements to components; inverse : (K, 3 n) the inverse; curves : (R, 3 n), R at most K
    strength : at 1 to the same curves, at 0 as `forward`
    """
    by_component = inverse @ curves.T
    lost = curves.T - forward @ by_component
    return np.asarray(forward + strength * lost @ np.linalg.pinv(by_component))
