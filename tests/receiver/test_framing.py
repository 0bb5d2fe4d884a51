import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.head_pose import HeadPose
from conf.receiver.framing import CENTRE, LOG_SCALE, SETTLE_SECONDS, Framer

number = st.floats(-0.5, 0.5)


def pose(x: float, y: float, log_scale: float) -> HeadPose:
    return HeadPose(np.array([0.1, 0.2, 0.3]), np.array([x, y]), log_scale)


@given(number, number, st.floats(-6.0, -2.0), st.lists(st.floats(0.0, 5.0), min_size=1, max_size=9))
def test_a_head_that_sits_still_is_centred_wherever_it_sits(
    x: float, y: float, scale: float, waits: list[float]
) -> None:
    framer, now = Framer(), 0.0
    for wait in waits:
        now += wait
        placed = framer.place(pose(x, y, scale), now)
        np.testing.assert_allclose(placed.position, CENTRE, atol=1e-9)
        assert placed.log_scale == pytest.approx(LOG_SCALE)
        np.testing.assert_array_equal(placed.rotation, [0.1, 0.2, 0.3])


def test_a_sway_is_kept_in_heads_not_in_picture_heights() -> None:
    near, far = Framer(), Framer()
    near.place(pose(0.0, 0.0, -3.0), 0.0)
    far.place(pose(0.0, 0.0, -4.0), 0.0)
    sway_near = near.place(pose(0.02, 0.0, -3.0), 0.02).position - CENTRE
    sway_far = far.place(pose(0.02 / np.e, 0.0, -4.0), 0.02).position - CENTRE
    assert sway_near[0] == pytest.approx(0.02 * np.exp(LOG_SCALE + 3.0), rel=0.02)
    np.testing.assert_allclose(sway_near, sway_far)


def test_someone_who_moves_to_another_seat_is_centred_again() -> None:
    framer = Framer()
    framer.place(pose(-0.3, 0.0, -3.5), 0.0)
    for i in range(1, 300):
        placed = framer.place(pose(0.3, 0.1, -4.0), i * SETTLE_SECONDS / 30)
    np.testing.assert_allclose(placed.position, CENTRE, atol=1e-3)
    assert placed.log_scale == pytest.approx(LOG_SCALE, abs=1e-3)


def test_a_clock_that_goes_back_changes_nothing() -> None:
    framer = Framer()
    framer.place(pose(0.0, 0.0, -3.0), 10.0)
    assert framer.place(pose(0.1, 0.0, -3.0), 9.0).position[0] > CENTRE[0]
