"""The shipped face prior is sound."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.default_head import default_points
from conf.face.fitting.face_prior import (
    DEPTH_MIRROR_INDICES,
    DEPTH_POSITIONS,
    OBSERVED_LANDMARKS,
    OBSERVED_MIRROR_INDICES,
    depth_residuals,
    load_prior,
    sample_depths,
)
from conf.face.similarity import fit_similarity
from conf.face.symmetry import MIRROR_INDICES

NO_TRIANGLES = np.zeros((0, 3), dtype=np.int32)


def test_mirror_indices_are_their_own_inverse() -> None:
    np.testing.assert_array_equal(OBSERVED_MIRROR_INDICES[OBSERVED_MIRROR_INDICES], np.arange(len(OBSERVED_LANDMARKS)))
    np.testing.assert_array_equal(OBSERVED_MIRROR_INDICES[:CONTROL_POINT_COUNT], MIRROR_INDICES)
    mirrored = load_prior().mean_observed[OBSERVED_MIRROR_INDICES] * [-1, 1, 1]
    assert np.linalg.norm(mirrored - load_prior().mean_observed, axis=1).max() < 0.6  # cm
    np.testing.assert_array_equal(DEPTH_POSITIONS[DEPTH_MIRROR_INDICES], DEPTH_POSITIONS * [-1, 1])


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_the_mean_observation_gives_the_mean_face(scale: float) -> None:
    prior, rng = load_prior(), np.random.default_rng(4)
    rotation = Rotation.from_rotvec(rng.normal(size=3) * 0.4).as_matrix()
    observed = scale * prior.mean_observed @ rotation.T + rng.normal(size=3) * 10
    points = prior.predict_points(prior.frame(observed).apply(observed), np.zeros((0, 3)), NO_TRIANGLES)
    np.testing.assert_allclose(points, prior.mean, atol=1e-6)


def test_a_ray_that_misses_the_mesh_has_no_depth_residual() -> None:
    residuals = depth_residuals(np.array([np.nan, 2.1, 9.0]), np.array([1.0, 2.0, 3.0]))
    assert residuals[0] == 0
    assert 0 < residuals[1] < residuals[2]
    assert np.isnan(sample_depths(np.zeros((0, 3)), NO_TRIANGLES)).all()
    square = np.array([[-20.0, -20, 0.5], [20, -20, 0.5], [20, 20, 0.5], [-20, 20, 0.5]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    assert sample_depths(square, triangles) == pytest.approx(np.full(len(DEPTH_POSITIONS), 0.5))


def test_the_mean_face_is_like_the_default_head() -> None:
    prior, points = load_prior(), default_points()
    aligned = fit_similarity(points, prior.mean).apply(points)
    assert np.linalg.norm(aligned - prior.mean, axis=1).max() < 1.0  # cm
    np.testing.assert_allclose(np.linalg.norm(prior.normals, axis=1), 1.0, atol=1e-3)
