import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.symmetry import MIRROR_INDICES
from conf.sender.tracking.blendshape_network import INDEX
from tools.train.expression import MIRRORED, Sample, fit_map, quiet_weights


def sample(seed: int, weights: np.ndarray) -> Sample:
    """Return a track of a person of their own whose points are moved by the weights."""
    random = np.random.default_rng(seed)
    person = random.normal(0, 3, (CONTROL_POINT_COUNT, 3))
    shapes = random.uniform(0, 1, (400, 52))
    return Sample("test", person + (shapes @ weights).reshape(-1, CONTROL_POINT_COUNT, 3), shapes)


def symmetric_map() -> np.ndarray:
    weights = np.random.default_rng(1).normal(0, 1, (52, CONTROL_POINT_COUNT, 3))
    mirrored = weights[MIRRORED][:, MIRROR_INDICES] * (-1, 1, 1)
    return ((weights + mirrored) / 2).reshape(52, -1)


def test_the_map_that_moved_the_points_is_found_whoever_was_tracked() -> None:
    weights = symmetric_map()
    found = fit_map([sample(seed, weights) for seed in range(3)])
    assert np.abs(found - weights).max() < 0.1


def test_a_mirrored_sample_has_the_weights_of_the_other_side() -> None:
    original = sample(0, symmetric_map())
    mirrored = original.mirrored()
    left, right = INDEX["mouthSmileLeft"], INDEX["mouthSmileRight"]
    assert MIRRORED[left] == right and MIRRORED[INDEX["jawOpen"]] == INDEX["jawOpen"]
    assert np.array_equal(mirrored.weights[:, left], original.weights[:, right])
    assert mirrored.mirrored().points == pytest.approx(original.points)


def test_quiet_weights_are_low_ones_and_the_same_on_both_sides() -> None:
    quiet = quiet_weights([sample(seed, symmetric_map()) for seed in range(2)])
    assert quiet == pytest.approx(np.full(52, 0.25), abs=0.07)
    assert quiet == pytest.approx(quiet[MIRRORED])
