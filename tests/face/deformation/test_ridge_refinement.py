import numpy as np
import pytest

from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.regions import InfluenceField, Regions
from conf.face.deformation.ridge_refinement import (
    blendshape_importance,
    jaw_weights,
    refine_with_blendshapes,
    subtract_jaw_motion,
)
from conf.face.deformation.rig import CHIN, Jaw
from tests.support.sheet_face import SheetFace

V, N, S = 40, 6, 12
WHOLE = Regions.unrestricted(V)
RNG = np.random.default_rng(5)
TRUE = RNG.normal(size=(V, N)).astype(np.float32)
PRIOR = RNG.normal(size=(V, N)).astype(np.float32)
MOVED = RNG.normal(size=(S, N, 3)).astype(np.float32)
OFFSETS = (TRUE @ MOVED).astype(np.float32)


def test_enough_shapes_teach_the_matrix_that_made_them() -> None:
    assert refine_with_blendshapes(PRIOR, MOVED, OFFSETS, regions=WHOLE, smoothing=1e-6) == pytest.approx(
        TRUE, abs=1e-3
    )


def test_without_trust_in_the_shapes_the_prior_stays() -> None:
    assert refine_with_blendshapes(PRIOR, MOVED, OFFSETS, regions=WHOLE, smoothing=1e9) == pytest.approx(
        PRIOR, abs=1e-3
    )


def test_what_no_shape_shows_stays_as_it_was() -> None:
    moved = MOVED.copy()
    moved[:, 2] = 0.0
    refined = refine_with_blendshapes(PRIOR, moved, TRUE @ moved, regions=WHOLE, smoothing=1e-6)
    assert refined[:, 2] == pytest.approx(PRIOR[:, 2])


def test_it_is_the_least_of_the_cost_it_names() -> None:
    def cost(matrix: np.ndarray) -> float:
        misses = ((matrix @ MOVED[:3] - OFFSETS[:3]) ** 2).sum(axis=(1, 2))
        return float(misses @ blendshape_importance(MOVED[:3]) ** 2 + 0.5 * ((matrix - PRIOR) ** 2).sum())

    best = refine_with_blendshapes(PRIOR, MOVED[:3], OFFSETS[:3], regions=WHOLE, smoothing=0.5)
    for seed in range(5):
        change = np.random.default_rng(seed).normal(size=(V, N)) * 1e-2
        assert cost(best + change) > cost(best)


def test_a_large_shape_does_not_drown_a_small_one() -> None:
    weights = blendshape_importance(np.stack([MOVED[0], MOVED[0] * 4, MOVED[0] * 0, MOVED[0] * 1e-9]))
    assert weights[1] == pytest.approx(weights[0] / 2)
    assert weights[2] == weights[3] < 3


def test_no_field_learns_what_it_leaves_out() -> None:
    weights = np.zeros(V)
    weights[:10] = 1.0
    prior = PRIOR.copy()
    prior[:10, 3] = 0.0
    regions = Regions((InfluenceField(weights, (3,)), InfluenceField(1 - weights, ())), np.empty((0, 3)))
    refined = refine_with_blendshapes(prior, MOVED, OFFSETS, regions=regions, smoothing=1e-6)
    assert not refined[:10, 3].any()
    assert refined[10:] == pytest.approx(TRUE[10:], abs=1e-3)


def shapes_of_a_jaw(shares: np.ndarray) -> Blendshapes:
    shifts = {"jawForward": [0, 0, 0.5], "jawLeft": [0.6, 0, 0], "smile": [0, 5, 0]}
    offsets = np.array([shares[:, None] * np.array(shift) for shift in shifts.values()], dtype=np.float32)
    return Blendshapes(tuple(shifts), offsets)


def test_shares_in_the_jaw_are_read_off_the_shapes_that_shift_it(face: SheetFace) -> None:
    shares = np.linspace(0, 1, 60)
    nearest = np.zeros(50, dtype=np.int64)
    nearest[CHIN] = 59  # the chin follows the jaw wholly
    assert jaw_weights(shapes_of_a_jaw(shares), nearest) == pytest.approx(shares, abs=1e-6)
    assert not jaw_weights(shapes_of_a_jaw(shares).subset([2]), nearest).any()


def test_a_shape_that_is_all_jaw_leaves_nothing_to_carry(face: SheetFace) -> None:
    centre, axis = np.array([0.0, 0.0, -4.0]), np.array([1.0, 0.0, 0.0])
    ones, arms = np.ones(50, dtype=np.float32), (face.points - centre).astype(np.float32)
    jaw = Jaw(centre, axis, np.arange(50), ones, arms, ones, arms)
    sine, cosine = np.sin(0.3), np.cos(0.3)
    turned = arms @ np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]).T - arms
    shapes = turned[None].astype(np.float32)
    displacements, offsets = subtract_jaw_motion(jaw, face.points, shapes, shapes)
    assert displacements == pytest.approx(0, abs=1e-5)
    assert offsets == pytest.approx(0, abs=1e-5)
    assert np.abs(shapes).max() > 1  # the arrays given are not touched
