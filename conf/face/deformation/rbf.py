"""Operator B: radial basis function interpolation, solved once for a face.

f(x) = P(x) + sum A_i g(|x - x_i|) interpolates the displacements of the control points at any position x. The
coefficients A and the polynomial P are linear in the displacements, so the solve, the evaluation at the vertices, the
regions of influence and the anchors (points whose displacement is always zero) fold into one matrix B:
offsets = B @ displacements.
Signs of the kernels are those of SciPy: a conditionally positive definite kernel is positive on the data it
interpolates, so multiquadric and linear are negative, and adding lambda to the diagonal always improves the condition.
Source: Noh, Fidaleo, Neumann 2000; Edge, Maddock 2003; the thesis, equations 4.1 to 4.7; Fasshauer, Meshfree
Approximation Methods with MATLAB, chapter 8 (minimum degrees of the polynomial); scipy.interpolate.RBFInterpolator.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from conf.face.deformation.regions import Regions

_MAX_CONDITION = 1e13  # above it a float64 solution is meaningless
_REGULARISATION = (1e-9, 1e-7, 1e-5, 1e-3)  # lambda, relative to the largest entry of the system
_CHUNK = 2048  # vertices at a time: their kernel values stay in the cache


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


@dataclass(frozen=True)
class Operator:
    """The matrix B and its regularisation.

    matrix : (V, n) float32, from displacements of the control points to vertex offsets
    smoothing : the lambda used; larger than requested if the system was singular with it
    """

    matrix: NDArray[np.float32]
    smoothing: float


def build_operator(
    vertices: NDArray[np.float64],
    control_points: NDArray[np.float64],
    /,
    *,
    kernel: Kernel,
    epsilon: float,
    regions: Regions | None = None,
    smoothing: float = 0.0,
) -> Operator:
    """Fold the RBF solve into one matrix from displacements to vertex offsets.

    vertices : (V, 3) model units, neutral pose
    control_points : (n, 3) model units, neutral pose
    epsilon : locality, 1/length; the larger, the more local the influence
    regions : where each point acts, and the anchors; None lets every point act everywhere
    smoothing : lambda, 0 interpolates exactly; a singular system is solved with a larger lambda
    Returns a (V, n) matrix.
    Raises ValueError if an argument has the wrong shape or is not finite, or all control points coincide.
    """
    _check(vertices, control_points, epsilon, smoothing)
    n = len(control_points)
    regions = regions or Regions.unrestricted(len(vertices))
    centres = np.concatenate([control_points, regions.anchors])
    basis = _Basis(centres, kernel, epsilon)
    everything = np.arange(len(centres))  # control points and anchors
    solved = [basis.solve(np.setdiff1d(everything, field.excluded), n, smoothing) for field in regions.fields]
    matrix = np.empty((len(vertices), n), dtype=np.float32)
    with np.errstate(under="ignore"):
        for start in range(0, len(vertices), _CHUNK):
            rows = slice(start, start + _CHUNK)
            values = basis.evaluate(vertices[rows])
            blended = np.zeros((len(values), n))
            for field, (coefficients, _) in zip(regions.fields, solved, strict=True):
                weights = field.weights[rows]
                inside = np.flatnonzero(weights)  # most vertices lie in one field only
                blended[inside] += weights[inside, None] * (values[inside] @ coefficients)
            matrix[rows] = blended
    return Operator(matrix, max(used for _, used in solved))


def _check(vertices: NDArray[np.float64], points: NDArray[np.float64], epsilon: float, smoothing: float) -> None:
    for name, array in (("vertices", vertices), ("control_points", points)):
        if array.ndim != 2 or array.shape[1] != 3 or not len(array) or not np.isfinite(array).all():
            raise ValueError(f"{name} must be finite with shape (any, 3), got shape {array.shape}")
    if not (np.isfinite(epsilon) and epsilon > 0):
        raise ValueError(f"epsilon must be positive, got {epsilon}")
    if not (np.isfinite(smoothing) and smoothing >= 0):
        raise ValueError(f"smoothing must not be negative, got {smoothing}")


class _Basis:
    """The functions g(|x - x_i|) of every centre and the monomials of P."""

    def __init__(self, centres: NDArray[np.float64], kernel: Kernel, epsilon: float) -> None:
        self._kernel, self._epsilon = kernel, epsilon
        self._centres = centres * epsilon
        # Monomials are scaled to [-1, 1], as in SciPy; otherwise they would dominate the system.
        self._centre = (centres.max(axis=0) + centres.min(axis=0)) / 2
        half_range = (centres.max(axis=0) - centres.min(axis=0)) / 2
        self._half_range = np.where(half_range > 0, half_range, 1.0)
        self._system = self.evaluate(centres)

    def evaluate(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (len(positions), centres + monomials) values of the functions."""
        values = self._kernel.function(cdist(positions * self._epsilon, self._centres, "sqeuclidean"))
        monomials = []
        if self._kernel.degree >= 0:
            monomials.append(np.ones((len(positions), 1)))
        if self._kernel.degree >= 1:
            monomials.append((positions - self._centre) / self._half_range)
        return np.concatenate([values, *monomials], axis=1) if monomials else values

    def solve(self, used: NDArray[np.intp], n: int, smoothing: float) -> tuple[NDArray[np.float64], float]:
        """Return the coefficients (centres + monomials, n) for unit displacements of n control points, and lambda.

        used : the centres of this field; the coefficients of the others are zero
        """
        centres, columns = self._system.shape
        rows = np.concatenate([used, np.arange(centres, columns)])
        system = np.zeros((len(rows), len(rows)))
        system[: len(used)] = self._system[np.ix_(used, rows)]
        system[len(used) :, : len(used)] = system[: len(used), len(used) :].T
        used_lambda, solution = _solve_regularised(system, len(used), smoothing)
        coefficients = np.zeros((columns, n))
        moving = used[used < n]
        coefficients[np.ix_(rows, moving)] = solution[:, : len(moving)]
        return coefficients, used_lambda


def _solve_regularised(
    system: NDArray[np.float64], kernels: int, smoothing: float
) -> tuple[float, NDArray[np.float64]]:
    """Invert the system with lambda on its first `kernels` diagonal entries; raise lambda until it is well-posed."""
    largest = float(np.abs(system).max())
    for factor in (0.0, *_REGULARISATION):
        used = max(smoothing, factor * largest)
        diagonal = np.full(len(system), used)
        # The block of the monomials too, if needed: points in one plane leave a linear polynomial undetermined.
        diagonal[kernels:] = -factor * largest
        regularised = system + np.diag(diagonal)
        if np.linalg.cond(regularised) < _MAX_CONDITION:
            return used, np.asarray(np.linalg.inv(regularised), dtype=np.float64)
    raise ValueError("control_points must not all coincide")
