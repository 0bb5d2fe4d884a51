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


def pose(x: float, y: float, log_scale: float, rotation: tuple[float, float, float] = (0.1, 0.2, 0.1)) -> HeadPose:
    return HeadPose(np.array(rotation), np.array([x, y]), log_scale)


@pytest.mark.slow
@given(number, number, st.floats(-6.0, -2.0), st.lists(st.floats(0.0, 5.0), min_size=1, max_size=9))
def test_a_still_head_is_centred_from_any_position(x: float, y: float, scale: float, waits: list[float]) -> None:
    framing, now = AutoFraming(), 0.0
    for wait in waits:
        now += wait
        framed = framing.frame(pose(x, y, scale), now, VGA)
        np.testing.assert_allclose(framed.position, CENTRE, atol=1e-9)
        assert framed.log_scale == pytest.approx(LOG_SCALE)
        np.testing.assert_array_equal(framed.rotation, [0.1, 0.2, 0.1])


def test_a_sway_keeps_its_size_relative_to_the_head() -> None:
    near, far = AutoFraming(), AutoFraming()
    near.frame(pose(0.0, 0.0, -3.0), 0.0, VGA)
    far.frame(pose(0.0, 0.0, -4.0), 0.0, VGA)
    sway_near = near.frame(pose(0.02, 0.0, -3.0), 0.002, VGA).position - CENTRE
    sway_far = far.frame(pose(0.02 / np.e, 0.0, -4.0), 0.002, VGA).position - CENTRE
    assert sway_near[0] == pytest.approx(0.02 * np.exp(LOG_SCALE + 3.0), rel=0.03)
    np.testing.assert_allclose(sway_near, sway_far)


@pytest.mark.slow
@given(
    st.lists(st.tuples(number, number, st.floats(-5.0, -2.0), number, number, number), min_size=1, max_size=30), sizes
)
def test_the_head_stays_inside_the_area_for_any_motion(
    moves: list[tuple[float, float, float, float, float, float]], size: tuple[int, int]
) -> None:
    framing, area = AutoFraming(), FrameArea.of(size)
    for i, (x, y, scale, *rotation) in enumerate(moves):
        framed = framing.frame(pose(x, y, scale, tuple(rotation)), i / 15, area)  # type: ignore[arg-type]
        centre, half = head_bounds(framed)
        assert (centre - half > [area.left, area.bottom]).all()
        assert (centre + half < [area.right, area.top]).all()
        assert abs(framed.log_scale - rest_pose(area).log_scale) <= LOG_GROWTH


def test_beside_a_panel_the_head_is_shifted_and_not_covered() -> None:
    area = FrameArea.of((640, 480), covered=184)
    framed = AutoFraming().frame(pose(0.0, 0.0, -3.5), 0.0, area)
    assert 0.07 < framed.position[0] < 0.14
    centre, half = head_bounds(framed)
    assert (centre - half)[0] > area.left == pytest.approx(184 / 480 - 640 / 480 / 2)


def test_a_head_that_moves_to_another_position_is_centred_again() -> None:
    framing = AutoFraming()
    framing.frame(pose(-0.3, 0.0, -3.5), 0.0)
    for i in range(1, 300):
        framed = framing.frame(pose(0.3, 0.1, -4.0), i * SETTLE_SECONDS / 30)
    np.testing.assert_allclose(framed.position, CENTRE, atol=1e-3)
    assert framed.log_scale == pytest.approx(LOG_SCALE, abs=1e-3)


def test_the_time_constant_is_shorter_at_the_start() -> None:
    def offset_after_a_second(start: float) -> float:
        framing = AutoFraming()
        for i in range(int(start * 20) + 1):
            framing.frame(pose(0.0, 0.0, -3.5), i / 20)
        for i in range(1, 21):
            framed = framing.frame(pose(0.02, 0.0, -3.5), start + i / 20)
        return float(framed.position[0])

    assert offset_after_a_second(0.0) < 0.5 * offset_after_a_second(10.0)


def test_a_clock_that_goes_back_does_not_change_the_average() -> None:
    framing = AutoFraming()
    framing.frame(pose(0.0, 0.0, -3.0), 10.0)
    assert framing.frame(pose(0.1, 0.0, -3.0), 9.0).position[0] > CENTRE[0]


def test_a_narrow_image_gets_a_smaller_head() -> None:
    assert rest_pose(FrameArea.of((200, 480))).log_scale < rest_pose(VGA).log_scale == math.log(0.029)
