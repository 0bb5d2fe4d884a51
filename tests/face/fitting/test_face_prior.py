"""The prior: similarities come back, a linear truth is learned, the shipped one is sound."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.default_head import DEFAULT_HEAD
from conf.face.fitting.face_prior import (
    DEPTH_POSITIONS,
    OBSERVED_LANDMARKS,
    OBSERVED_MIRROR_INDICES,
    TrainingHead,
    depth_residuals,
    load_prior,
    sample_depths,
    train_prior,
)
from conf.face.formats.ppc import read_ppc
from conf.face.similarity import SimilarityTransform, fit_similarity
from conf.face.symmetry import MIRROR_INDICES


def moved(points: NDArray[np.float64], seed: int, scale: float) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_rotvec(rng.normal(size=3) * 0.4).as_matrix()
    return scale * points @ rotation.T + rng.normal(size=3) * 10


@given(seed=st.integers(0, 99), scale=st.floats(1e-3, 1e3))
def test_a_similarity_is_found_again(seed: int, scale: float) -> None:
    points = np.random.default_rng(1).normal(size=(12, 3))
    frame = fit_similarity(moved(points, seed, scale), points)
    np.testing.assert_allclose(frame.apply(moved(points, seed, scale)), points, atol=1e-9)
    np.testing.assert_allclose(frame.inverse_apply(frame.apply(points)), points, atol=1e-9)


def test_a_similarity_scales_then_turns_then_shifts() -> None:
    quarter = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    frame = SimilarityTransform(quarter, 2.0, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(frame.apply(np.array([1.0, 0.0, 0.0])), [0.0, 2.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(frame.then(frame).apply(np.eye(3)), frame.apply(frame.apply(np.eye(3))), atol=1e-12)


def test_partners_are_each_others() -> None:
    np.testing.assert_array_equal(OBSERVED_MIRROR_INDICES[OBSERVED_MIRROR_INDICES], np.arange(len(OBSERVED_LANDMARKS)))
    np.testing.assert_array_equal(OBSERVED_MIRROR_INDICES[:CONTROL_POINT_COUNT], MIRROR_INDICES)
    across = load_prior().mean_observed[OBSERVED_MIRROR_INDICES] * [-1, 1, 1]
    assert np.linalg.norm(across - load_prior().mean_observed, axis=1).max() < 0.6  # cm


NOTHING = np.zeros((0, 3), dtype=np.int32)


def known(observed: NDArray[np.float64], truth: NDArray[np.float64], mesh: tuple[NDArray, NDArray]) -> TrainingHead:
    return TrainingHead(observed, truth, np.ones_like(truth), *mesh)


def wall(depth: float) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return a square before which every face stands."""
    square = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    return square + np.array([0.0, 0.0, depth]), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)


def test_a_linear_error_is_learned() -> None:
    """The truth is what is seen, shifted, and more so on broad faces."""
    rng = np.random.default_rng(2)
    base = load_prior().mean_observed
    broad = rng.normal(size=60)
    observed = base + broad[:, None, None] * 0.05 * base * [1.0, 0.0, 0.0] + rng.normal(size=(60, *base.shape)) * 0.01
    truth = observed[:, :CONTROL_POINT_COUNT] + [0.0, 0.2, 0.0]
    truth[:, :, 2] += 0.1 * broad[:, None]
    prior = train_prior([known(o, t, wall(0.0)) for o, t in zip(observed[:50], truth[:50], strict=True)], ridge=0.01)
    for seen, true in zip(observed[50:], truth[50:], strict=True):
        frame = prior.frame(seen)
        vertices, triangles = wall(0.0)
        found = prior.predict_points(frame.apply(seen), frame.apply(vertices), triangles)
        assert np.linalg.norm(found - frame.apply(true), axis=1).max() < 0.06


def test_the_surface_says_what_the_tracker_does_not() -> None:
    """The tracker sees the same every time; how far the surface stands out tells how far down the chin is."""
    depths = np.random.default_rng(3).uniform(-0.8, 0.8, 40)
    base = load_prior().mean_observed
    truth = np.repeat(base[None, :CONTROL_POINT_COUNT], 40, axis=0)
    truth[:, 0, 1] -= depths
    prior = train_prior([known(base, t, wall(z)) for t, z in zip(truth, depths, strict=True)], ridge=0.01)
    errors = [prior.predict_points(base, *wall(z))[0, 1] - t[0, 1] for t, z in zip(truth, depths, strict=True)]
    assert np.abs(errors).max() < 0.02
    far = prior.predict_points(base, *wall(9.0))[0, 1]  # hair, or another part of the head: no more than the most
    assert far == pytest.approx(prior.predict_points(base, *wall(1.1))[0, 1], abs=0.1)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_an_average_observation_gives_an_average_face(scale: float) -> None:
    prior = load_prior()
    seen = moved(prior.mean_observed, 4, scale)
    found = prior.predict_points(prior.frame(seen).apply(seen), np.zeros((0, 3)), NOTHING)
    np.testing.assert_allclose(found, prior.mean, atol=1e-6)


def test_a_hole_does_not_stand_out() -> None:
    average = np.array([1.0, 2.0, 3.0])
    off = depth_residuals(np.array([np.nan, 2.1, 9.0]), average)
    assert off[0] == 0
    assert 0 < off[1] < off[2]
    assert np.isnan(sample_depths(np.zeros((0, 3)), NOTHING)).all()
    assert sample_depths(*wall(0.5)) == pytest.approx(np.full(len(DEPTH_POSITIONS), 0.5))


def test_the_average_face_is_like_the_default_head() -> None:
    prior, points = load_prior(), read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    aligned = fit_similarity(points, prior.mean).apply(points)
    assert np.linalg.norm(aligned - prior.mean, axis=1).max() < 1.0  # cm
    np.testing.assert_allclose(np.linalg.norm(prior.normals, axis=1), 1.0, atol=1e-3)
