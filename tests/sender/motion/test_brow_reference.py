import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_LANDMARKS, control_point_indices
from conf.face.loading import load_face
from conf.sender.motion.brow_reference import _WEIGHTS, BRIDGE_LANDMARK, points_with_brows_from_bridge
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.fidelity_tracks import DrawnHead

BROWS = control_point_indices("brow")


def mean_landmarks() -> np.ndarray:
    """Return landmarks (478, 3) of the mean face, cm, with the mean bridge."""
    aligned = np.zeros((478, 3))
    aligned[CONTROL_POINT_LANDMARKS] = MEAN_FACE
    aligned[BRIDGE_LANDMARK] = 0.0, 3.23, 5.28
    return aligned


def test_the_mean_face_is_unchanged() -> None:
    assert np.allclose(points_with_brows_from_bridge(mean_landmarks()), MEAN_FACE)


def test_the_weights_are_those_of_the_default_head() -> None:
    head = DrawnHead(load_face())
    assert np.abs(head.face.operator[head.bridge] - _WEIGHTS).max() < 0.04


@pytest.mark.parametrize("seed", range(5))
def test_drawn_brows_are_as_far_from_the_drawn_bridge_as_filmed(seed: int) -> None:
    generator, aligned = np.random.default_rng(seed), mean_landmarks()
    aligned[CONTROL_POINT_LANDMARKS] += generator.normal(0, 0.2, (len(CONTROL_POINT_LANDMARKS), 3))
    aligned[BRIDGE_LANDMARK, 1] += generator.normal(0, 0.2)
    moved = points_with_brows_from_bridge(aligned)
    drawn_bridge = 3.23 + _WEIGHTS @ (moved - MEAN_FACE)[:, 1]
    filmed = aligned[CONTROL_POINT_LANDMARKS[BROWS], 1] - aligned[BRIDGE_LANDMARK, 1]
    assert np.allclose(moved[BROWS, 1] - drawn_bridge, filmed)
    others = np.setdiff1d(np.arange(len(moved)), BROWS)
    assert np.array_equal(moved[others], aligned[CONTROL_POINT_LANDMARKS[others]])
    assert np.array_equal(moved[:, [0, 2]], aligned[CONTROL_POINT_LANDMARKS][:, [0, 2]])
