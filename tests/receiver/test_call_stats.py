import pytest

from conf.receiver.call_stats import HISTORY_INTERVAL_S, HISTORY_LENGTH, CallStatsCollector, state_of
from tests.support.simulated_calls import PARAMETERS, SimulatedSender, exchange, make_receiver, no_face, talk


def test_without_a_call_the_state_is_waiting_and_all_numbers_are_zero() -> None:
    stats = CallStatsCollector(make_receiver()).collect(5.0, paused=False)
    assert stats.state == "waiting"
    assert (stats.traffic.wire_kbps, stats.traffic.ratio, stats.points) == (0.0, 0.0, 0)
    assert stats.round_trip_ms is None


@pytest.mark.slow
def test_the_state_follows_the_call() -> None:
    endpoint, caller = make_receiver(), SimulatedSender(0.0)
    collector = CallStatsCollector(endpoint)
    now = exchange(endpoint, caller, 0.0, 3.0)
    assert collector.collect(now, paused=False).state == "receiving"
    assert collector.collect(now, paused=True).state == "paused"
    caller.motion = no_face
    now = exchange(endpoint, caller, now, 3.0)
    assert collector.collect(now, paused=False).state == "no face"
    caller.motion = talk
    now = exchange(endpoint, caller, now, 3.0)
    assert collector.collect(now, paused=False).state == "receiving"
    assert collector.collect(now + 4.0, paused=False).state == "lost"
    for data, _ in caller.connection.close(now):
        endpoint.receive_datagram(data, caller.address, now)
    assert collector.collect(now, paused=False).state == "call ended"


@pytest.mark.slow
def test_the_state_of_several_calls_is_that_of_the_best() -> None:
    endpoint = make_receiver()
    silent, talking = SimulatedSender(0.0), SimulatedSender(0.0, address=("10.0.0.8", 99))
    now = exchange(endpoint, silent, 0.0, 1.0)
    now = exchange(endpoint, talking, now, 5.0)
    calls = list(endpoint.streams.values())
    assert [call.is_silent(now) for call in calls] == [True, False]
    assert state_of(calls, now, had_calls=True) == "receiving"


@pytest.mark.slow
def test_the_statistics_are_those_of_the_traffic_and_the_stream() -> None:
    endpoint, caller = make_receiver(), SimulatedSender(0.0)
    now = exchange(endpoint, caller, 0.0, 4.0)
    stats = CallStatsCollector(endpoint).collect(now, paused=False)
    assert stats.traffic == endpoint.snapshot(now) and stats.traffic.frames_received > 30
    assert (stats.width, stats.height, stats.points) == (PARAMETERS.width, PARAMETERS.height, PARAMETERS.points)


def test_the_frame_rate_and_the_bit_rates_of_the_last_minute_are_kept() -> None:
    collector = CallStatsCollector(make_receiver())
    for i in range(4 * HISTORY_LENGTH):
        collector.on_frame_drawn(i * HISTORY_INTERVAL_S / 2)
    stats = collector.collect(1e3, paused=False)
    assert stats.fps == pytest.approx(2 / HISTORY_INTERVAL_S)
    assert len(stats.history) == HISTORY_LENGTH
    assert stats.history_seconds == HISTORY_LENGTH * HISTORY_INTERVAL_S
