"""The table of radial basis functions.

Signs are those of SciPy: a conditionally positive definite kernel is positive on the data it interpolates, so
multiquadric and linear are negative, and adding lambda to the diagonal always improves the condition of the system.
Source: Fasshauer, Meshfree Approximation Methods with MATLAB, chapter 8 (minimum degrees);
scipy.interpolate.RBFInterpolator.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Squares = NDArray[np.float64]


@dataclass(frozen=True)
class Kernel:
    """A radial basis function of r = epsilon * distance, with the degree of the polynomial added to it.

    function : replaces an array of r squared by the function's values, in place
    degree : -1 none, 0 constant, 1 linear; the table holds the minimum for a well-posed system
    scipy_name : name in scipy.interpolate.RBFInterpolator
    epsilon : default locality for a face with 6.4 cm between the pupils, 1/cm
    """

    name: str
    function: Callable[[Squares], Squares]
    degree: int
    scipy_name: str
    epsilon: float


def _gaussian(squared: Squares) -> Squares:
    np.minimum(squared, 80.0, out=squared)  # exp(-80) is 0 in float32
    np.negative(squared, out=squared)
    return np.exp(squared, out=squared)


def _multiquadric(squared: Squares) -> Squares:
    squared += 1.0
    np.sqrt(squared, out=squared)
    return np.negative(squared, out=squared)


def _inverse_multiquadric(squared: Squares) -> Squares:
    squared += 1.0
    np.sqrt(squared, out=squared)
    return np.reciprocal(squared, out=squared)


def _linear(squared: Squares) -> Squares:
    np.sqrt(squared, out=squared)
    return np.negative(squared, out=squared)


def _thin_plate(squared: Squares) -> Squares:
    logarithm = np.log(np.maximum(squared, 1e-30))  # r^2 log r goes to 0 with r
    squared *= logarithm
    squared *= 0.5
    return squared


KERNELS = {
    kernel.name: kernel
    for kernel in (
        Kernel("gaussian", _gaussian, -1, "gaussian", 0.4),
        Kernel("multiquadric", _multiquadric, 0, "multiquadric", 1.0),
        Kernel("inverse-multiquadric", _inverse_multiquadric, -1, "inverse_multiquadric", 0.5),
        Kernel("linear", _linear, 0, "linear", 1.0),
        Kernel("thin-plate", _thin_plate, 1, "thin_plate_spline", 1.0),
    )
}
