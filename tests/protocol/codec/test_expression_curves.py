"""Components are chosen so that the curves of an expression survive, and the points stay as near as they were."""

from importlib import resources

import numpy as np
import pytest

from conf.protocol.codec.expression_curves import STRENGTH, keep_curves, load_curves
from conf.protocol.codec.model import FILE, build_models, load_models
from tests.support.synthetic_motion import talking

COORDINATES, COMPONENTS, CURVES = 30, 8, 3


def maps(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a matrix to components, its inverse, and curves."""
    random = np.random.default_rng(seed)
    inverse = random.normal(size=(COMPONENTS, COORDINATES))
    return np.linalg.pinv(inverse), inverse, random.normal(size=(CURVES, COORDINATES))


@pytest.mark.parametrize("seed", range(4))
def test_components_decode_to_the_same_curves(seed: int) -> None:
    forward, inverse, curves = maps(seed)
    displacements = np.random.default_rng(seed).normal(size=(20, COORDINATES))
    decoded = displacements @ keep_curves(forward, inverse, curves, strength=1.0) @ inverse
    assert decoded @ curves.T == pytest.approx(displacements @ curves.T)
    assert np.abs((displacements @ forward @ inverse - displacements) @ curves.T).max() > 0.1  # without


@pytest.mark.parametrize("seed", range(4))
def test_what_components_can_represent_is_represented_as_before(seed: int) -> None:
    forward, inverse, curves = maps(seed)
    kept = keep_curves(forward, inverse, curves, strength=1.0)
    assert inverse @ kept == pytest.approx(np.eye(COMPONENTS), abs=1e-9)


def test_the_change_of_the_components_is_the_smallest_that_does_it() -> None:
    forward, inverse, curves = maps(0)
    displacements = np.random.default_rng(9).normal(size=COORDINATES)
    before, after = displacements @ forward, displacements @ keep_curves(forward, inverse, curves, strength=1.0)
    _, _, rows = np.linalg.svd((inverse @ curves.T).T)
    free = rows[CURVES:]  # changes of the components that change no curve
    assert free @ (after - before) == pytest.approx(np.zeros(len(free)), abs=1e-9)


def test_shipped_curves_are_independent() -> None:
    """Float32 rounding would make a dependent one a constraint that nothing can meet."""
    for model in load_models().values():
        values = np.linalg.svd(model.transform.inverse_matrix @ load_curves().T, compute_uv=False)
        assert values.min() > 0.05 * values.max(), model.profile.name


def test_only_payloads_of_one_frame_keep_curves_and_half_of_what_they_lost() -> None:
    with resources.files("conf.assets").joinpath(FILE).open("rb") as file, np.load(file) as arrays:
        plain = build_models(dict(arrays))
    curves, kept = load_curves(), load_models()
    for name, model in plain.items():
        for frame in talking(40):
            flat = frame.displacements.reshape(-1).astype(np.float64)
            lost, still_lost = (
                curves @ (flat @ each.transform.forward_matrix @ each.transform.inverse_matrix - flat)
                for each in (model, kept[name])
            )
            share = 1 - STRENGTH if name in ("live", "voice") else 1.0
            assert still_lost == pytest.approx(share * lost, abs=1e-5), name
