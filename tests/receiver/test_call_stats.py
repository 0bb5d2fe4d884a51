import pytest

from conf.receiver.call_stats import HISTORY_INTERVAL_S, HISTORY_LENGTH, CallStatsCollector, state_of
from tests.support.fake_senders import PARAMETERS, FakeCaller, new_host, talk


def test_without_a_call_the_state_is_waiting_and_all_numbers_are_zero() -> None:
    stats = CallStatsCollector(new_host()).collect(5.0, paused=False)
    assert stats.state == "waiting"
    assert (stats.traffic.wire_kbps, stats.traffic.ratio, stats.points) == (0.0, 0.0, 0)
    assert stats.round_trip_ms is None


def test_the_state_follows_the_call() -> None:
    endpoint, caller = new_host(), FakeCaller(0.0)
    collector = CallStatsCollector(endpoint)
    now = talk(endpoint, caller, 0.0, 3.0)
    assert collector.collect(now, paused=False).state == "receiving"
    assert collector.collect(now, paused=True).state == "paused"
    caller.shows = "nobody"
    now = talk(endpoint, caller, now, 3.0)
    assert collector.collect(now, paused=False).state == "no face"
    caller.shows = "face"
    now = talk(endpoint, caller, now, 3.0)
    assert collector.collect(now, paused=False).state == "receiving"
    assert collector.collect(now + 4.0, paused=False).state == "lost"
    for data, address in caller.hang_up(now):
        endpoint.receive_datagram(data, address, now)
    assert collector.collect(now, paused=False).state == "call ended"


def test_the_state_of_several_calls_is_that_of_the_best() -> None:
    endpoint = new_host()
    silent, talking = FakeCaller(0.0), FakeCaller(0.0, address=("10.0.0.8", 99))
    now = talk(endpoint, silent, 0.0, 1.0)
    now = talk(endpoint, talking, now, 5.0)
    calls = list(endpoint.streams.values())
    assert [call.is_silent(now) for call in calls] == [True, False]
    assert state_of(calls, now, had_calls=True) == "receiving"


def test_the_statistics_are_those_of_the_traffic_and_the_stream() -> None:
    endpoint, caller = new_host(), FakeCaller(0.0)
    now = talk(endpoint, caller, 0.0, 4.0)
    stats = CallStatsCollector(endpoint).collect(now, paused=False)
    assert stats.traffic == endpoint.snapshot(now) and stats.traffic.frames_received > 30
    assert (stats.width, stats.height, stats.points) == (PARAMETERS.width, PARAMETERS.height, PARAMETERS.points)


def test_the_frame_rate_and_the_bit_rates_of_the_last_minute_are_kept() -> None:
    collector = CallStatsCollector(new_host())
    for i in range(4 * HISTORY_LENGTH):
        collector.on_frame_drawn(i * HISTORY_INTERVAL_S / 2)
    stats = collector.collect(1e3, paused=False)
    assert stats.fps == pytest.approx(2 / HISTORY_INTERVAL_S)
    assert len(stats.history) == HISTORY_LENGTH
    assert stats.history_seconds == HISTORY_LENGTH * HISTORY_INTERVAL_S
