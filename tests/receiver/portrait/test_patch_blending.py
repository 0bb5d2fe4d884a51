import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.portrait.patch_blending import MAX_VISIBLE, blend_weights, compositing_order

KEYS = st.lists(st.lists(st.floats(-100, 100), min_size=3, max_size=3), min_size=1, max_size=8)


@given(st.lists(st.floats(-100, 100), min_size=3, max_size=3), KEYS)
def test_shares_are_shares_of_a_few(now: list[float], keys: list[list[float]]) -> None:
    shares = blend_weights(np.array(now), [np.array(key) for key in keys])
    assert abs(shares.sum() - 1) < 1e-9
    assert (shares >= 0).all() and np.count_nonzero(shares > 1e-12) <= max(MAX_VISIBLE, 1)


@given(KEYS, st.integers(0, 2**32 - 1))
def test_shares_do_not_jump(keys: list[list[float]], seed: int) -> None:
    rng = np.random.default_rng(seed)
    now, candidates = rng.uniform(-100, 100, 3), [np.array(key) for key in keys]
    a, b = blend_weights(now, candidates), blend_weights(now + 1e-6, candidates)
    distances = sorted(float(np.linalg.norm(now - key)) for key in candidates)
    clear = len(distances) <= MAX_VISIBLE or distances[MAX_VISIBLE] - distances[0] > 1
    if clear:
        assert np.abs(a - b).max() < 1e-3


def test_the_nearest_shows_most() -> None:
    shares = blend_weights(np.zeros(1), [np.array([40.0]), np.array([1.0]), np.array([20.0])])
    assert np.argmax(shares) == 1 and shares[1] > 0.9


@given(st.dictionaries(st.integers(-1, 6), st.floats(0.01, 1), min_size=1))
def test_painting_the_layers_gives_the_shares(weights: dict[int, float]) -> None:
    total = sum(weights.values())
    shares = {candidate: weight / total for candidate, weight in weights.items()}
    shown = {-1: 1.0}
    for candidate, opacity in compositing_order(shares):
        shown = {c: s * (1 - opacity) for c, s in shown.items()} | {candidate: opacity}
    for candidate, share in shares.items():
        assert abs(shown[candidate] - share) < 1e-6
