"""Face priors trained on synthetic observations."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fitting.face_prior import load_prior
from tools.train.face_prior_fit import TrainingHead, nearest_normals, train_prior

BALL = trimesh.creation.icosphere(subdivisions=3, radius=2.0)


def training_head(
    observed: NDArray[np.float64], truth: NDArray[np.float64], mesh: tuple[NDArray[np.float64], NDArray[np.int32]]
) -> TrainingHead:
    return TrainingHead(observed, truth, np.ones_like(truth), *mesh)


def wall(depth: float) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return a square parallel to the image plane, larger than a face."""
    square = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    return square + np.array([0.0, 0.0, depth]), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)


@pytest.mark.slow
def test_a_linear_error_is_learned() -> None:
    """The truth is the observation shifted, and shifted more on broad faces."""
    rng = np.random.default_rng(2)
    base = load_prior().mean_observed
    breadth = rng.normal(size=60)
    observed = base + breadth[:, None, None] * 0.05 * base * [1.0, 0.0, 0.0]
    observed += rng.normal(size=(60, *base.shape)) * 0.01
    truth = observed[:, :CONTROL_POINT_COUNT] + [0.0, 0.2, 0.0]
    truth[:, :, 2] += 0.1 * breadth[:, None]
    heads = [training_head(o, t, wall(0.0)) for o, t in zip(observed[:50], truth[:50], strict=True)]
    prior = train_prior(heads, ridge=0.01)
    for landmarks, points in zip(observed[50:], truth[50:], strict=True):
        frame = prior.frame(landmarks)
        vertices, triangles = wall(0.0)
        predicted = prior.predict_points(frame.apply(landmarks), frame.apply(vertices), triangles)
        assert np.linalg.norm(predicted - frame.apply(points), axis=1).max() < 0.06


def test_depths_correct_what_the_landmarks_do_not_show() -> None:
    """The landmarks never change; the height of the chin depends on the depth of the surface."""
    depths = np.random.default_rng(3).uniform(-0.8, 0.8, 40)
    base = load_prior().mean_observed
    truth = np.repeat(base[None, :CONTROL_POINT_COUNT], 40, axis=0)
    truth[:, 0, 1] -= depths
    heads = [training_head(base, t, wall(z)) for t, z in zip(truth, depths, strict=True)]
    prior = train_prior(heads, ridge=0.01)
    errors = [prior.predict_points(base, *wall(z))[0, 1] - t[0, 1] for t, z in zip(truth, depths, strict=True)]
    assert np.abs(errors).max() < 0.02
    far = prior.predict_points(base, *wall(9.0))[0, 1]  # hair, or another part of the head: clipped
    assert far == pytest.approx(prior.predict_points(base, *wall(1.1))[0, 1], abs=0.1)


def test_the_normals_of_a_ball_are_its_radii() -> None:
    vertices = np.asarray(BALL.vertices)
    normals = nearest_normals(vertices[:5], vertices, np.asarray(BALL.faces, dtype=np.int32))
    np.testing.assert_allclose(normals, vertices[:5] / 2.0, atol=0.02)
