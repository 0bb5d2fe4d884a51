"""Components are chosen so that the curves of an expression survive, and the points stay as near as they were."""

import numpy as np
import pytest

from conf.protocol.codec.expression_curves import keep_curves, load_curves
from conf.protocol.codec.model import load_models
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
    decoded = displacements @ keep_curves(forward, inverse, curves) @ inverse
    assert decoded @ curves.T == pytest.approx(displacements @ curves.T)
    assert np.abs((displacements @ forward @ inverse - displacements) @ curves.T).max() > 0.1  # without


@pytest.mark.parametrize("seed", range(4))
def test_what_components_can_represent_is_represented_as_before(seed: int) -> None:
    forward, inverse, curves = maps(seed)
    kept = keep_curves(forward, inverse, curves)
    assert inverse @ kept == pytest.approx(np.eye(COMPONENTS), abs=1e-9)


def test_the_change_of_the_components_is_the_smallest_that_does_it() -> None:
    forward, inverse, curves = maps(0)
    displacements = np.random.default_rng(9).normal(size=COORDINATES)
    before, after = displacements @ forward, displacements @ keep_curves(forward, inverse, curves)
    _, _, rows = np.linalg.svd((inverse @ curves.T).T)
    free = rows[CURVES:]  # changes of the components that change no curve
    assert free @ (after - before) == pytest.approx(np.zeros(len(free)), abs=1e-9)


def test_shipped_curves_are_independent() -> None:
    """Float32 rounding would make a dependent one a constraint that nothing can meet."""
    for model in load_models().values():
        values = np.linalg.svd(model.transform.inverse_matrix @ load_curves().T, compute_uv=False)
        assert values.min() > 0.05 * values.max(), model.profile.name


@pytest.mark.parametrize("name", ["live", "voice"])
def test_shipped_curves_of_motion_survive_the_choice_of_components(name: str) -> None:
    transform, curves = load_models()[name].transform, load_curves()
    for frame in talking(40):
        flat = frame.displacements.reshape(-1).astype(np.float64)
        decoded = flat @ transform.forward_matrix @ transform.inverse_matrix
        assert curves @ decoded == pytest.approx(curves @ flat, abs=1e-4)


def test_only_payloads_of_one_frame_keep_curves() -> None:
    curves, frame = load_curves(), talking(1)[0].displacements.reshape(-1).astype(np.float64)
    kept = set()
    for name, model in load_models().items():
        decoded = frame @ model.transform.forward_matrix @ model.transform.inverse_matrix
        if np.abs(curves @ (decoded - frame)).max() < 1e-4:
            kept.add(name)
    assert kept == {"live", "voice"}
