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
UNRESTRICTED = Regions.unrestricted(V)
RNG = np.random.default_rng(5)
TARGET = RNG.normal(size=(V, N)).astype(np.float32)
PRIOR = RNG.normal(size=(V, N)).astype(np.float32)
MOVED = RNG.normal(size=(S, N, 3)).astype(np.float32)
OFFSETS = (TARGET @ MOVED).astype(np.float32)


def test_enough_blendshapes_determine_the_matrix() -> None:
    assert refine_with_blendshapes(PRIOR, MOVED, OFFSETS, regions=UNRESTRICTED, smoothing=1e-6) == pytest.approx(
        TARGET, abs=1e-3
    )


def test_a_large_lambda_keeps_the_prior() -> None:
    assert refine_with_blendshapes(PRIOR, MOVED, OFFSETS, regions=UNRESTRICTED, smoothing=1e9) == pytest.approx(
        PRIOR, abs=1e-3
    )


def test_columns_without_displacement_keep_the_prior() -> None:
    moved = MOVED.copy()
    moved[:, 2] = 0.0
    refined = refine_with_blendshapes(PRIOR, moved, TARGET @ moved, regions=UNRESTRICTED, smoothing=1e-6)
    assert refined[:, 2] == pytest.approx(PRIOR[:, 2])


def test_the_refined_matrix_minimises_the_cost() -> None:
    def cost(matrix: np.ndarray) -> float:
        errors = ((matrix @ MOVED[:3] - OFFSETS[:3]) ** 2).sum(axis=(1, 2))
        return float(errors @ blendshape_importance(MOVED[:3]) ** 2 + 0.5 * ((matrix - PRIOR) ** 2).sum())

    best = refine_with_blendshapes(PRIOR, MOVED[:3], OFFSETS[:3], regions=UNRESTRICTED, smoothing=0.5)
    for seed in range(5):
        change = np.random.default_rng(seed).normal(size=(V, N)) * 1e-2
        assert cost(best + change) > cost(best)


def test_large_blendshapes_get_smaller_weights() -> None:
    weights = blendshape_importance(np.stack([MOVED[0], MOVED[0] * 4, MOVED[0] * 0, MOVED[0] * 1e-9]))
    assert weights[1] == pytest.approx(weights[0] / 2)
    assert weights[2] == weights[3] < 3


def test_excluded_points_stay_excluded() -> None:
    weights = np.zeros(V)
    weights[:10] = 1.0
    prior = PRIOR.copy()
    prior[:10, 3] = 0.0
    regions = Regions((InfluenceField(weights, (3,)), InfluenceField(1 - weights, ())), np.empty((0, 3)))
    refined = refine_with_blendshapes(prior, MOVED, OFFSETS, regions=regions, smoothing=1e-6)
    assert not refined[:10, 3].any()
    assert refined[10:] == pytest.approx(TARGET[10:], abs=1e-3)


def jaw_blendshapes(weights: np.ndarray) -> Blendshapes:
    offsets_by_name = {"jawForward": [0, 0, 0.5], "jawLeft": [0.6, 0, 0], "smile": [0, 5, 0]}
    offsets = np.array([weights[:, None] * np.array(offset) for offset in offsets_by_name.values()], dtype=np.float32)
    return Blendshapes(tuple(offsets_by_name), offsets)


def test_jaw_weights_come_from_the_jaws_translations(face: SheetFace) -> None:
    weights = np.linspace(0, 1, 60)
    nearest = np.zeros(50, dtype=np.int64)
    nearest[CHIN] = 59  # the chin follows the jaw with weight 1
    assert jaw_weights(jaw_blendshapes(weights), nearest) == pytest.approx(weights, abs=1e-6)
    assert not jaw_weights(Blendshapes(("smile",), jaw_blendshapes(weights).offsets[2:]), nearest).any()


def test_a_blendshape_of_the_jaw_alone_has_no_remainder(face: SheetFace) -> None:
    centre, axis = np.array([0.0, 0.0, -4.0]), np.array([1.0, 0.0, 0.0])
    ones, arms = np.ones(50, dtype=np.float32), (face.points - centre).astype(np.float32)
    jaw = Jaw(centre, axis, np.arange(50), ones, arms, ones, arms)
    sine, cosine = np.sin(0.3), np.cos(0.3)
    rotated = arms @ np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]).T - arms
    shapes = rotated[None].astype(np.float32)
    displacements, offsets = subtract_jaw_motion(jaw, face.points, shapes, shapes)
    assert displacements == pytest.approx(0, abs=1e-5)
    assert offsets == pytest.approx(0, abs=1e-5)
    assert np.abs(shapes).max() > 1  # the arguments are unchanged
