from dataclasses import replace

import pytest

from conf.call.link_state import HOLD_S, LinkMonitor, LinkState, Quality
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import LinkStatus
from conf.protocol.stream_clocks import Medium

WELL = LinkStatus(True, False, "voice", 1, 40.0, 0.5, 3.0)


def stream(now: float, *, lost: int = 0, received: int = 100) -> ReceiveLeg:
    """Return a stream that has received datagrams, the newest at `now`, with gaps between them."""
    leg = ReceiveLeg()
    step = (lost + received) / received
    for number in range(received):
        leg.on_datagram(b"", 50, now)
        leg.reception.add(round(number * step), now, timestamp=number / 15)
    return leg


def test_without_a_call_there_is_nothing_to_judge() -> None:
    monitor = LinkMonitor()
    assert monitor.update(WELL, None, 1.0) == LinkState(Quality.NONE)
    assert monitor.update(replace(WELL, connected=False), stream(1.0), 1.0).text == "waiting"


def test_a_link_without_trouble_is_good() -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    assert [monitor.update(WELL, leg, 10.0 + i).text for i in range(3)] == ["good"] * 3


@pytest.mark.parametrize(
    ("status", "text"),
    [
        (replace(WELL, loss_percent=12.4), "weak: loss 12 %"),
        (replace(WELL, round_trip_ms=520.0), "weak: delay 520 ms"),
        (replace(WELL, profile="narrow"), "weak: the link is slow"),
    ],
)
def test_a_weak_link_says_why_and_for_long_enough_to_be_read(status: LinkStatus, text: str) -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    monitor.update(WELL, leg, 10.0)
    assert monitor.update(status, leg, 10.5).text == text
    assert monitor.update(WELL, leg, 10.6).text == text
    leg.on_datagram(b"", 50, 10.5 + HOLD_S)
    assert monitor.update(WELL, leg, 10.6 + HOLD_S).text == "good"


def test_a_rate_that_was_low_from_the_start_is_the_user_s_choice() -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    assert monitor.update(replace(WELL, profile="slow"), leg, 10.0).text == "good"


def test_what_is_lost_on_the_way_here_counts_too() -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    monitor.update(WELL, leg, 10.0)
    for number in range(100, 160, 2):
        leg.on_datagram(b"", 50, 12.0)
        leg.reception.add(number, 12.0, timestamp=number / 15)
    assert monitor.update(WELL, leg, 12.0).text.startswith("weak: loss ")


def test_an_uneven_delay_is_weak() -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    for number in range(30):
        leg.clock.on_arrival(number / 10, 7.0 + number / 10 + (0.4 if number % 3 == 0 else 0.0), medium=Medium.MOTION)
    assert monitor.update(WELL, leg, 10.0).text.startswith("weak: uneven delay, 4")


def test_silence_and_a_peer_that_hears_nothing_are_lost() -> None:
    monitor, leg = LinkMonitor(), stream(10.0)
    assert monitor.update(WELL, leg, 14.2) == LinkState(Quality.LOST, "no reply for 4 s")
    assert monitor.update(replace(WELL, stopped=True), leg, 11.0) == LinkState(Quality.LOST, "nothing arrives there")
