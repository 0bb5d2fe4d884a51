import numpy as np
import pytest

from conf.protocol.stream_clocks import (
    CLOCK_RESET_S,
    DELAY_DECAY,
    MARGIN_S,
    MAX_DELAY_S,
    OFFSET_WINDOW_S,
    Medium,
    PeerStreamClock,
    PlayoutClock,
    StreamClock,
)


def filled(lateness: dict[Medium, float], seconds: float = 5.0) -> PlayoutClock:
    """Return a clock to which both media came every 0.1 s for a while, each with its own lateness."""
    clock = PlayoutClock()
    for step in range(round(seconds * 10)):
        for medium, late_s in lateness.items():
            clock.on_arrival(step / 10, 100 + step / 10 + late_s, medium=medium)
    return clock


def test_the_delay_follows_the_worse_medium_and_the_offset_the_better() -> None:
    clock = filled({Medium.MOTION: 0.04, Medium.VOICE: 0.24})
    assert clock.delay_s == pytest.approx(0.2 + MARGIN_S)
    assert clock.playhead(110.0) == pytest.approx(10.0 - 0.04 - 0.2 - MARGIN_S)
    assert filled({Medium.MOTION: 0.24, Medium.VOICE: 0.04}).delay_s == pytest.approx(0.2 + MARGIN_S)
    assert filled({Medium.MOTION: 0.04}).delay_s == pytest.approx(MARGIN_S)


@pytest.mark.slow
def test_two_per_cent_of_each_medium_may_be_late() -> None:
    """Frequent motion does not hide that every voice packet is late."""
    clock = PlayoutClock()
    for step in range(900):
        now = step / 100
        clock.on_arrival(now, now)
        if step % 50 == 49:
            clock.on_arrival(now - 0.3, now, medium=Medium.VOICE)
    assert clock.delay_s == pytest.approx(0.3 + MARGIN_S)


def test_the_extra_delay_moves_the_playhead_only() -> None:
    clock = filled({Medium.MOTION: 0.0})
    before, delay_s = clock.playhead(110.0), clock.delay_s
    clock.extra_delay_s = 0.07
    assert clock.playhead(110.0) == pytest.approx(before - 0.07) and clock.delay_s == delay_s


@pytest.mark.parametrize("packet_s", [0.0, 0.48, 0.96])
def test_the_delay_is_bounded_beyond_the_duration_of_a_packet(packet_s: float) -> None:
    clock = PlayoutClock()
    clock.packet_s = packet_s
    clock.on_arrival(0.0, 0.0)
    for step in range(49):  # the arrival without delay is still in the window
        clock.on_arrival(step / 10, 5 + step / 10, medium=Medium.VOICE)
    assert clock.delay_s == MAX_DELAY_S + packet_s


def test_the_delay_falls_slowly_and_the_offset_follows_ten_seconds() -> None:
    clock = filled({Medium.MOTION: 0.0, Medium.VOICE: 0.3})
    late = clock.delay_s
    now = 105.0 + OFFSET_WINDOW_S + 0.5
    clock.on_arrival(now - 100, now)
    assert clock.delay_s == pytest.approx(late - DELAY_DECAY * 0.3)
    clock.on_arrival(now - 100.2, now + 0.1)
    assert clock.playhead(now) == pytest.approx(now - 100 - clock.delay_s), "the shortest way of the window"


def test_a_clock_that_starts_again_is_noticed() -> None:
    clock = filled({Medium.MOTION: 0.0, Medium.VOICE: 0.1})
    clock.on_arrival(4.9 - CLOCK_RESET_S + 1, 104.9)
    assert clock.restarts == 0
    clock.on_arrival(0.0, 104.9 + CLOCK_RESET_S + 1)
    assert clock.restarts == 1
    assert clock.playhead(104.9 + CLOCK_RESET_S + 1) == pytest.approx(-clock.delay_s)


def test_before_the_first_arrival_the_playhead_is_the_receivers_clock() -> None:
    assert PlayoutClock().playhead(7.0) == 7.0 and np.isfinite(PlayoutClock().playhead(-7.0))


def test_the_first_capture_time_is_stream_time_zero_until_a_restart() -> None:
    clock = StreamClock()
    assert (clock.offset(50.0), clock.offset(51.5), clock.offset(49.0)) == (0.0, 1.5, -1.0)
    assert (clock.stream_time(51.5), clock.stream_time(49.0)) == (1.5, 0.0)
    clock.restart()
    assert clock.stream_time(60.0) == 0.0 and clock.stream_time(60.25) == 0.25


def test_the_peers_time_goes_on_from_the_newest_that_is_known() -> None:
    clock = PeerStreamClock()
    assert clock.time(5.0) is None
    clock.advance(3.0, 100.0)
    assert clock.time(100.5) == 3.5
    clock.advance(2.0, 101.0)
    assert clock.time(101.0) == 4.0, "older content does not set the clock back"
    clock.advance(6.0, 102.0)
    assert clock.time(102.0) == 6.0
    clock.set(1.0, 103.0)
    assert clock.time(104.0) == 2.0


def test_motion_is_as_late_as_the_sound_and_catches_up_if_nobody_reports_any_more() -> None:
    clock = filled({Medium.MOTION: 0.0})
    assert clock.motion_playhead(110.0) == clock.playhead(110.0)
    for late_s in (0.2, -0.2):
        clock.follow_sound(late_s, 110.0)
        assert clock.motion_playhead(109.0) == pytest.approx(clock.playhead(109.0) - late_s)
        assert clock.motion_playhead(110.0) == pytest.approx(clock.playhead(110.0) - late_s)
        assert clock.motion_playhead(111.0) == pytest.approx(clock.playhead(111.0) - late_s / 2)
        assert clock.motion_playhead(113.0) == clock.playhead(113.0)
