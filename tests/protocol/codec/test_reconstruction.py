"""The reconstruction: what it estimates is bounded, and it lessens the error of motion that it was fitted to."""

import numpy as np
import pytest

from conf.protocol.codec.model import load_models
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.reconstruction import HISTORY, Reconstruction, near
from conf.protocol.codec.reference_frames import LOG_SCALE

SHIPPED = {name: model.transform.reconstruction for name, model in load_models().items()}


def test_only_distances_up_to_a_step_are_near() -> None:
    np.testing.assert_array_equal(near(np.array([-1.5, -1.0, 0.5, 1.0, 2.0])), [0, -1, 0.5, 1, 0])


def test_each_part_of_the_estimate_is_linear_in_clipped_values() -> None:
    history = np.zeros((HISTORY, 2, 2))
    history[0, 0, 1], history[1, 1, 0] = 0.25, 0.125
    reconstruction = Reconstruction(np.array([0.5, 0.0]), history)
    values = np.array([3.0, 0.0])
    np.testing.assert_allclose(reconstruction.expected_error(values, []), [0, 0])
    previous = np.array([4.0, 4.0])
    np.testing.assert_allclose(reconstruction.expected_error(values, [previous]), [0.5, 0.25])
    second = np.array([3.0, -7.0])
    np.testing.assert_allclose(reconstruction.expected_error(values, [previous, second]), [0.5 - 0.125, 0.25])


@pytest.mark.parametrize("name", PROFILES)
def test_the_log_scale_stays(name: str) -> None:
    """The face centre is measured in the log scale that was sent."""
    reconstruction = SHIPPED[name]
    assert not reconstruction.previous[LOG_SCALE] and not reconstruction.history[:, :, LOG_SCALE].any()


@pytest.mark.parametrize("name", PROFILES)
def test_a_value_that_crossed_a_border_alone_is_moved_back_by_less_than_half_a_step(name: str) -> None:
    reconstruction = SHIPPED[name]
    for value in range(1, len(reconstruction.previous)):
        values = np.zeros(len(reconstruction.previous))
        before = values.copy()
        before[value] = 1
        assert -0.05 < reconstruction.expected_error(values, [before, before])[value] < 0.55
