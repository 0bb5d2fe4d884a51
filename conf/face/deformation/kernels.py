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


@dataclass(frozen=True)
class Kernel:
    """A radial basis function of r = epsilon * distance, with the degree of the polynomial added to it.

    function : from an array of r squared to the function's values
    degree : -1 none, 0 constant, 1 linear; the table holds the minimum for a well-posed system
    epsilon : default locality for a face with 6.4 cm between the pupils, 1/cm
    """

    function: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    degree: int
    epsilon: float


KERNELS = {
    "gaussian": Kernel(lambda s: np.exp(-np.minimum(s, 80.0)), -1, 0.4),  # exp(-80) is 0 in float32
    "multiquadric": Kernel(lambda s: -np.sqrt(s + 1.0), 0, 1.0),
    "inverse-multiquadric": Kernel(lambda s: 1.0 / np.sqrt(s + 1.0), -1, 0.5),
    "linear": Kernel(lambda s: -np.sqrt(s), 0, 1.0),
    "thin-plate": Kernel(lambda s: s * np.log(np.maximum(s, 1e-30)) * 0.5, 1, 1.0),  # r^2 log r goes to 0 with r
}
