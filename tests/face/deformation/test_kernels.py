import numpy as np
import pytest

from conf.face.deformation.kernels import KERNELS, Kernel

FORMULAS = {
    "gaussian": lambda r: np.exp(-(r**2)),
    "multiquadric": lambda r: -np.sqrt(1 + r**2),
    "inverse-multiquadric": lambda r: 1 / np.sqrt(1 + r**2),
    "linear": lambda r: -r,
    "thin-plate": lambda r: r**2 * np.log(np.where(r > 0, r, 1)),
}
kernels = pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)


@pytest.mark.parametrize("name", KERNELS)
def test_kernels_match_their_formulas_with_scipys_signs(name: str) -> None:
    r = np.linspace(0, 6, 100)
    assert KERNELS[name].function(r**2) == pytest.approx(FORMULAS[name](r), abs=1e-12)


@kernels
def test_every_kernel_is_conditionally_positive_definite(kernel: Kernel) -> None:
    points = np.random.default_rng(2).normal(size=(30, 3))
    squared = ((points[:, None] - points) ** 2).sum(axis=-1)
    matrix = kernel.function(squared)
    monomials = np.column_stack([np.ones(30), points])[:, : {-1: 0, 0: 1, 1: 4}[kernel.degree]]
    null_space = np.linalg.svd(monomials, full_matrices=True)[0][:, monomials.shape[1] :]
    assert np.linalg.eigvalsh(null_space.T @ matrix @ null_space).min() > 0


@kernels
def test_kernels_are_finite_at_zero_and_far_away(kernel: Kernel) -> None:
    assert np.isfinite(kernel.function(np.array([0.0, 1e-30, 1e12]))).all()
