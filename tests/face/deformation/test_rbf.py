from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator

from conf.face.deformation.rbf import KERNELS, Kernel, build_operator
from conf.face.deformation.regions import InfluenceField, Regions
from tests.support.sheet_face import SheetFace

kernels = pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
MULTIQUADRIC = KERNELS["multiquadric"]
NO_ANCHORS = np.empty((0, 3))


@pytest.mark.slow
@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("degree", [None, 1])
@pytest.mark.parametrize("smoothing", [0.0, 0.05])
def test_the_operator_agrees_with_scipys_interpolator(
    face: SheetFace, name: str, degree: int | None, smoothing: float
) -> None:
    vertices = face.mesh.vertices[::7]
    displacements = np.random.default_rng(3).normal(size=face.points.shape)
    kernel = KERNELS[name] if degree is None else replace(KERNELS[name], degree=degree)
    oracle = RBFInterpolator(
        face.points,
        displacements,
        kernel=cast(Any, "thin_plate_spline" if name == "thin-plate" else name.replace("-", "_")),
        epsilon=kernel.epsilon,
        degree=kernel.degree,
        smoothing=smoothing,
    )
    operator = build_operator(vertices, face.points, kernel=kernel, epsilon=kernel.epsilon, smoothing=smoothing)
    assert operator.matrix.dtype == np.float32
    assert operator.smoothing == smoothing
    expected = oracle(vertices)
    # Far from the points a gaussian field of random displacements rises to 1e3; the comparison is relative there.
    assert operator.matrix @ displacements == pytest.approx(expected, abs=1e-5 * max(1, np.abs(expected).max()))


@kernels
def test_without_smoothing_control_points_are_interpolated_exactly(face: SheetFace, kernel: Kernel) -> None:
    operator = build_operator(face.points, face.points, kernel=kernel, epsilon=kernel.epsilon)
    assert operator.matrix == pytest.approx(np.eye(len(face.points)), abs=1e-5)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_the_operator_is_linear_in_float32(face: SheetFace, seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = build_operator(face.mesh.vertices[::50], face.points, kernel=MULTIQUADRIC, epsilon=1.0).matrix
    a, b = rng.normal(size=(2, *face.points.shape)).astype(np.float32)
    assert matrix @ (a + 2 * b) == pytest.approx(matrix @ a + 2 * (matrix @ b), abs=1e-4)


@pytest.mark.slow
def test_the_operator_does_not_depend_on_the_unit(face: SheetFace) -> None:
    vertices = face.mesh.vertices[::20]
    cm = build_operator(vertices, face.points, kernel=MULTIQUADRIC, epsilon=1.0).matrix
    mm = build_operator(vertices * 10, face.points * 10, kernel=MULTIQUADRIC, epsilon=0.1).matrix
    assert mm == pytest.approx(cm, abs=1e-6)


@pytest.mark.parametrize("unit", [1e-7, 1e7])
@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (1e6, -2e6, 3e6)])
def test_a_polynomial_stays_well_conditioned_in_any_unit_and_place(
    face: SheetFace, unit: float, origin: tuple[float, float, float]
) -> None:
    thin_plate, vertices = KERNELS["thin-plate"], face.mesh.vertices[::100]
    near = build_operator(vertices, face.points, kernel=thin_plate, epsilon=1.0)
    points, positions = (np.asarray(array + np.array(origin)) * unit for array in (face.points, vertices))
    far = build_operator(positions, points, kernel=thin_plate, epsilon=1.0 / unit)
    assert near.smoothing == far.smoothing == 0
    assert far.matrix == pytest.approx(near.matrix, abs=1e-5)


def test_each_row_depends_on_its_vertex_only(face: SheetFace) -> None:
    vertices = face.mesh.vertices[:5000]
    halves = Regions(
        (InfluenceField(np.linspace(0, 1, 5000), (3,)), InfluenceField(np.linspace(1, 0, 5000), ())), NO_ANCHORS
    )
    together = build_operator(vertices, face.points, kernel=MULTIQUADRIC, epsilon=1.0, regions=halves).matrix
    for rows in (slice(0, 3), slice(2046, 2050), slice(4094, 4098), slice(4990, 5000)):
        part = Regions(tuple(InfluenceField(f.weights[rows], f.excluded) for f in halves.fields), NO_ANCHORS)
        alone = build_operator(vertices[rows], face.points, kernel=MULTIQUADRIC, epsilon=1.0, regions=part).matrix
        assert together[rows] == pytest.approx(alone, abs=1e-6)


def test_values_too_small_for_float32_are_no_error(face: SheetFace) -> None:
    far = np.array([[0.0, 0.0, 60.0]])
    regions = Regions((InfluenceField(np.array([1e-9]), ()),), NO_ANCHORS)
    with np.errstate(all="raise"):
        operator = build_operator(far, face.points, kernel=KERNELS["gaussian"], epsilon=0.5, regions=regions)
    assert np.abs(operator.matrix).max() < 1e-35


def test_lambda_is_relative_to_the_kernel(face: SheetFace) -> None:
    """A kernel a thousand times as large needs a lambda a thousand times as large, and gives the same operator."""
    points = face.points.copy()
    points[1] = points[2]
    large = replace(MULTIQUADRIC, function=lambda squared: 1000 * MULTIQUADRIC.function(squared), degree=-1)
    small = replace(MULTIQUADRIC, degree=-1)
    ours, theirs = (build_operator(points, points, kernel=kernel, epsilon=1.0) for kernel in (small, large))
    assert theirs.smoothing == pytest.approx(1000 * ours.smoothing) and ours.smoothing > 0
    assert theirs.matrix == pytest.approx(ours.matrix, abs=1e-4)


def test_anchors_do_not_move(face: SheetFace) -> None:
    anchors = np.array([[11.0, 11.0, 0.0], [-11.0, 11.0, 0.0], [0.0, -13.5, 2.0]])
    regions = Regions.unrestricted(len(anchors), anchors=anchors)
    operator = build_operator(anchors, face.points, kernel=MULTIQUADRIC, epsilon=1.0, regions=regions)
    assert np.abs(operator.matrix).max() < 1e-5


def test_excluded_points_have_no_influence_in_a_field(face: SheetFace) -> None:
    half = np.full(len(face.points), 0.5)
    regions = Regions((InfluenceField(half, (0, 1)), InfluenceField(half, (0,))), NO_ANCHORS)
    matrix = build_operator(face.points, face.points, kernel=MULTIQUADRIC, epsilon=1.0, regions=regions).matrix
    assert not matrix[:, 0].any()
    assert matrix[1, 1] == pytest.approx(0.5, abs=0.5)
    assert matrix[2:, 2:] == pytest.approx(np.eye(48), abs=1e-5)


@kernels
def test_coinciding_points_are_regularised(face: SheetFace, kernel: Kernel) -> None:
    points = face.points.copy()
    points[1] = points[2]
    operator = build_operator(points, points, kernel=kernel, epsilon=kernel.epsilon)
    assert operator.smoothing > 0
    displacements = np.zeros((50, 1))
    displacements[[1, 2]] = 1.0
    assert (operator.matrix @ displacements)[1] == pytest.approx([1.0], abs=0.05)


def test_an_almost_constant_kernel_is_regularised(face: SheetFace) -> None:
    operator = build_operator(face.points, face.points, kernel=KERNELS["gaussian"], epsilon=0.001)
    assert operator.smoothing > 0
    assert np.isfinite(operator.matrix).all()


def test_coplanar_points_are_solvable_with_a_linear_polynomial(face: SheetFace) -> None:
    flat = face.points * [1, 1, 0]
    operator = build_operator(flat, flat, kernel=KERNELS["thin-plate"], epsilon=1.0)
    assert operator.matrix == pytest.approx(np.eye(50), abs=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vertices": np.zeros((3, 2))}, "vertices must be finite with shape"),
        ({"points": np.full((50, 3), np.nan)}, "control_points must be finite with shape"),
        ({"epsilon": 0.0}, "epsilon must be positive"),
        ({"epsilon": np.nan}, "epsilon must be positive"),
        ({"smoothing": -1.0}, "smoothing must not be negative"),
    ],
)
def test_bad_arguments_raise(face: SheetFace, change: dict[str, object], message: str) -> None:
    arguments: dict[str, Any] = {"vertices": face.mesh.vertices, "points": face.points, "epsilon": 1.0} | change
    vertices, points = arguments.pop("vertices"), arguments.pop("points")
    with pytest.raises(ValueError, match=message):
        build_operator(vertices, points, kernel=MULTIQUADRIC, **arguments)


def test_points_that_all_coincide_are_refused() -> None:
    points = np.ones((4, 3))
    zero = replace(MULTIQUADRIC, function=np.zeros_like, degree=-1)
    with pytest.raises(ValueError, match="control_points must not all coincide"):
        build_operator(points, points, kernel=zero, epsilon=1.0)


FORMULAS = {
    "gaussian": lambda r: np.exp(-(r**2)),
    "multiquadric": lambda r: -np.sqrt(1 + r**2),
    "inverse-multiquadric": lambda r: 1 / np.sqrt(1 + r**2),
    "linear": lambda r: -r,
    "thin-plate": lambda r: r**2 * np.log(np.where(r > 0, r, 1)),
}


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
