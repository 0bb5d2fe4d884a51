import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.head_pose import HeadPose
from conf.render.auto_framing import (
    CENTRE,
    LOG_GROWTH,
    LOG_SCALE,
    SETTLE_SECONDS,
    AutoFraming,
    FrameArea,
    head_bounds,
    rest_pose,
)

number = st.floats(-0.5, 0.5)
sizes = st.tuples(st.integers(200, 2000), st.integers(200, 2000)).filter(lambda size: size[0] > size[1] / 2)
VGA = FrameArea.of((640, 480))


def pose(x: float, y: float, log_scale: float, turn: tuple[float, float, float] = (0.1, 0.2, 0.1)) -> HeadPose:
    return HeadPose(np.array(turn), np.array([x, y]), log_scale)


@given(number, number, st.floats(-6.0, -2.0), st.lists(st.floats(0.0, 5.0), min_size=1, max_size=9))
def test_a_head_that_sits_still_is_centred_wherever_it_sits(
    x: float, y: float, scale: float, waits: list[float]
) -> None:
    framer, now = AutoFraming(), 0.0
    for wait in waits:
        now += wait
        placed = framer.frame(pose(x, y, scale), now, VGA)
        np.testing.assert_allclose(placed.position, CENTRE, atol=1e-9)
        assert placed.log_scale == pytest.approx(LOG_SCALE)
        np.testing.assert_array_equal(placed.rotation, [0.1, 0.2, 0.1])


def test_a_sway_is_kept_in_heads_not_in_picture_heights() -> None:
    near, far = AutoFraming(), AutoFraming()
    near.frame(pose(0.0, 0.0, -3.0), 0.0, VGA)
    far.frame(pose(0.0, 0.0, -4.0), 0.0, VGA)
    sway_near = near.frame(pose(0.02, 0.0, -3.0), 0.002, VGA).position - CENTRE
    sway_far = far.frame(pose(0.02 / np.e, 0.0, -4.0), 0.002, VGA).position - CENTRE
    assert sway_near[0] == pytest.approx(0.02 * np.exp(LOG_SCALE + 3.0), rel=0.03)
    np.testing.assert_allclose(sway_near, sway_far)


@given(
    st.lists(st.tuples(number, number, st.floats(-5.0, -2.0), number, number, number), min_size=1, max_size=30), sizes
)
def test_the_whole_head_stays_inside_whatever_the_man_does(
    moves: list[tuple[float, float, float, float, float, float]], size: tuple[int, int]
) -> None:
    framer, area = AutoFraming(), FrameArea.of(size)
    for i, (x, y, scale, *turn) in enumerate(moves):
        placed = framer.frame(pose(x, y, scale, tuple(turn)), i / 15, area)  # type: ignore[arg-type]
        middle, half = head_bounds(placed)
        assert (middle - half > [area.left, area.bottom]).all()
        assert (middle + half < [area.right, area.top]).all()
        assert abs(placed.log_scale - rest_pose(area).log_scale) <= LOG_GROWTH


def test_beside_the_meter_the_head_moves_over_and_is_not_covered() -> None:
    area = FrameArea.of((640, 480), covered=184)
    placed = AutoFraming().frame(pose(0.0, 0.0, -3.5), 0.0, area)
    assert 0.07 < placed.position[0] < 0.14
    middle, half = head_bounds(placed)
    assert (middle - half)[0] > area.left == pytest.approx(184 / 480 - 640 / 480 / 2)


def test_someone_who_moves_to_another_seat_is_centred_again() -> None:
    framer = AutoFraming()
    framer.frame(pose(-0.3, 0.0, -3.5), 0.0)
    for i in range(1, 300):
        placed = framer.frame(pose(0.3, 0.1, -4.0), i * SETTLE_SECONDS / 30)
    np.testing.assert_allclose(placed.position, CENTRE, atol=1e-3)
    assert placed.log_scale == pytest.approx(LOG_SCALE, abs=1e-3)


def test_at_the_start_the_picture_settles_quickly_later_slowly() -> None:
    def left_after_a_second(start: float) -> float:
        framer = AutoFraming()
        for i in range(int(start * 20) + 1):
            framer.frame(pose(0.0, 0.0, -3.5), i / 20)
        for i in range(1, 21):
            placed = framer.frame(pose(0.02, 0.0, -3.5), start + i / 20)
        return float(placed.position[0])

    assert left_after_a_second(0.0) < 0.5 * left_after_a_second(10.0)


def test_a_clock_that_goes_back_changes_nothing() -> None:
    framer = AutoFraming()
    framer.frame(pose(0.0, 0.0, -3.0), 10.0)
    assert framer.frame(pose(0.1, 0.0, -3.0), 9.0).position[0] > CENTRE[0]


def test_a_narrow_picture_gets_a_smaller_head() -> None:
    assert rest_pose(FrameArea.of((200, 480))).log_scale < rest_pose(VGA).log_scale == math.log(0.029)
