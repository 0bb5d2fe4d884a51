import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.portrait.image_blending import MAX_VISIBLE, blend_weights, compositing_order

DESCRIPTORS = st.lists(st.lists(st.floats(-100, 100), min_size=3, max_size=3), min_size=1, max_size=8)


@pytest.mark.slow
@given(st.lists(st.floats(-100, 100), min_size=3, max_size=3), DESCRIPTORS)
def test_weights_sum_to_one_and_few_are_positive(current: list[float], descriptors: list[list[float]]) -> None:
    weights = blend_weights(np.array(current), [np.array(descriptor) for descriptor in descriptors])
    assert abs(weights.sum() - 1) < 1e-9
    assert (weights >= 0).all() and np.count_nonzero(weights > 1e-12) <= max(MAX_VISIBLE, 1)


@pytest.mark.slow
@given(DESCRIPTORS, st.integers(0, 2**32 - 1))
def test_weights_are_continuous(descriptors: list[list[float]], seed: int) -> None:
    rng = np.random.default_rng(seed)
    current, candidates = rng.uniform(-100, 100, 3), [np.array(descriptor) for descriptor in descriptors]
    a, b = blend_weights(current, candidates), blend_weights(current + 1e-6, candidates)
    distances = sorted(float(np.linalg.norm(current - candidate)) for candidate in candidates)
    distinct = len(distances) <= MAX_VISIBLE or distances[MAX_VISIBLE] - distances[0] > 1
    if distinct:
        assert np.abs(a - b).max() < 1e-3


def test_the_nearest_candidate_has_the_highest_weight() -> None:
    weights = blend_weights(np.zeros(1), [np.array([40.0]), np.array([1.0]), np.array([20.0])])
    assert np.argmax(weights) == 1 and weights[1] > 0.9


@pytest.mark.slow
@given(st.dictionaries(st.integers(-1, 6), st.floats(0.01, 1), min_size=1))
def test_compositing_the_layers_yields_the_weights(weights: dict[int, float]) -> None:
    total = sum(weights.values())
    weights = {candidate: weight / total for candidate, weight in weights.items()}
    composite = {-1: 1.0}
    for candidate, opacity in compositing_order(weights):
        composite = {c: w * (1 - opacity) for c, w in composite.items()} | {candidate: opacity}
    for candidate, weight in weights.items():
        assert abs(composite[candidate] - weight) < 1e-6
