import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from conf.face.similarity import SimilarityTransform, fit_similarity

vectors = hnp.arrays(np.float64, 3, elements=st.floats(-2, 2))


@pytest.mark.slow
@given(vectors, st.floats(0.01, 100), vectors, st.integers(0, 1000))
def test_a_known_similarity_is_recovered(rotvec: np.ndarray, scale: float, translation: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, weights = rng.normal(size=(12, 3)), rng.uniform(0.1, 1, 12)
    rotation = Rotation.from_rotvec(rotvec).as_matrix()
    fit = fit_similarity(source, scale * source @ rotation.T + translation, weights)
    assert np.allclose(fit.rotation, rotation, atol=1e-7)
    assert fit.scale == pytest.approx(scale, rel=1e-9)
    assert np.allclose(fit.translation, translation, atol=1e-7 * max(scale, 1))


@pytest.mark.slow
@given(st.integers(0, 1000))
def test_no_nearby_similarity_fits_noisy_points_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, target, weights = rng.normal(size=(8, 3)), rng.normal(size=(8, 3)), rng.uniform(0.1, 1, 8)
    fit = fit_similarity(source, target, weights)

    def error(rotation: np.ndarray, scale: float, translation: np.ndarray) -> float:
        return float(weights @ np.sum((scale * source @ rotation.T + translation - target) ** 2, axis=1))

    best = error(fit.rotation, fit.scale, fit.translation)
    assert np.linalg.det(fit.rotation) == pytest.approx(1)
    for _ in range(20):
        nudge = Rotation.from_rotvec(rng.normal(scale=0.05, size=3)).as_matrix()
        assert best <= error(nudge @ fit.rotation, fit.scale * rng.uniform(0.9, 1.1), fit.translation) + 1e-9


@pytest.mark.slow
@given(st.integers(0, 1000))
def test_inverse_and_composition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (
        SimilarityTransform(
            Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.uniform(0.1, 9), rng.normal(size=3)
        )
        for _ in range(2)
    )
    points = rng.normal(size=(5, 3))
    assert np.allclose(first.inverse_apply(first.apply(points)), points)
    assert np.allclose(first.then(second).apply(points), second.apply(first.apply(points)))
