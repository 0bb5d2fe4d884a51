"""The prior: similarities come back, a linear truth is learned, the shipped one is sound."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.face_prior import SEEN_LANDMARKS, SEEN_PARTNERS, learn_prior, load_prior
from conf.face.head import DEFAULT_HEAD
from conf.face.ppc import read_ppc
from conf.face.similarity import Similarity, fit_similarity
from conf.face.symmetry import PARTNERS


def moved(points: NDArray[np.float64], seed: int, scale: float) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_rotvec(rng.normal(size=3) * 0.4).as_matrix()
    return scale * points @ rotation.T + rng.normal(size=3) * 10


@given(seed=st.integers(0, 99), scale=st.floats(1e-3, 1e3))
def test_a_similarity_is_found_again(seed: int, scale: float) -> None:
    points = np.random.default_rng(1).normal(size=(12, 3))
    frame = fit_similarity(moved(points, seed, scale), points)
    np.testing.assert_allclose(frame.apply(moved(points, seed, scale)), points, atol=1e-9)
    np.testing.assert_allclose(frame.undo(frame.apply(points)), points, atol=1e-9)


def test_a_similarity_scales_then_turns_then_shifts() -> None:
    quarter = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    frame = Similarity(quarter, 2.0, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(frame.apply(np.array([1.0, 0.0, 0.0])), [0.0, 2.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(frame.then(frame).apply(np.eye(3)), frame.apply(frame.apply(np.eye(3))), atol=1e-12)


def test_partners_are_each_others() -> None:
    np.testing.assert_array_equal(SEEN_PARTNERS[SEEN_PARTNERS], np.arange(len(SEEN_LANDMARKS)))
    np.testing.assert_array_equal(SEEN_PARTNERS[:CONTROL_POINT_COUNT], PARTNERS)
    across = load_prior().seen[SEEN_PARTNERS] * [-1, 1, 1]
    assert np.linalg.norm(across - load_prior().seen, axis=1).max() < 0.6  # cm


def test_a_linear_error_is_learned() -> None:
    """The truth is what is seen, shifted, and more so on broad faces."""
    rng = np.random.default_rng(2)
    base = load_prior().seen
    broad = rng.normal(size=60)
    observed = base + broad[:, None, None] * 0.05 * base * [1.0, 0.0, 0.0] + rng.normal(size=(60, *base.shape)) * 0.01
    truth = observed[:, :CONTROL_POINT_COUNT] + [0.0, 0.2, 0.0]
    truth[:, :, 2] += 0.1 * broad[:, None]
    prior = learn_prior(observed[:50], truth[:50], np.ones_like(truth[:50]), ridge=0.01)
    for seen, true in zip(observed[50:], truth[50:], strict=True):
        frame = prior.frame(seen)
        found = prior.likely_points(frame.apply(seen))
        assert np.linalg.norm(found - frame.apply(true), axis=1).max() < 0.06


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_an_average_observation_gives_an_average_face(scale: float) -> None:
    prior = load_prior()
    seen = moved(prior.seen, 4, scale)
    np.testing.assert_allclose(prior.likely_points(prior.frame(seen).apply(seen)), prior.mean, atol=1e-6)


def test_the_average_face_is_like_the_default_head() -> None:
    prior, points = load_prior(), read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    aligned = fit_similarity(points, prior.mean).apply(points)
    assert np.linalg.norm(aligned - prior.mean, axis=1).max() < 1.0  # cm
    np.testing.assert_allclose(np.linalg.norm(prior.normals, axis=1), 1.0, atol=1e-3)
