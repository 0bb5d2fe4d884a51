import pytest

from conf.receiver.call_stats import HISTORY_EVERY_S, HISTORY_LENGTH, CallStatsCollector, state_of
from tests.support.fake_senders import PARAMETERS, FakeCaller, new_host, talk


def test_nobody_is_waited_for() -> None:
    host = new_host()
    reading = CallStatsCollector(host).collect(5.0, paused=False)
    assert reading.state == "waiting"
    assert (reading.wire_kbps, reading.ratio, reading.saved_percent, reading.points) == (0.0, 0.0, 0.0, 0)
    assert reading.round_trip_ms is None


def test_the_state_follows_the_call() -> None:
    host, caller = new_host(), FakeCaller(0.0)
    readings = CallStatsCollector(host)
    now = talk(host, caller, 0.0, 3.0)
    assert readings.collect(now, paused=False).state == "receiving"
    assert readings.collect(now, paused=True).state == "paused"
    caller.shows = "nobody"
    now = talk(host, caller, now, 3.0)
    assert readings.collect(now, paused=False).state == "no face"
    caller.shows = "face"
    now = talk(host, caller, now, 3.0)
    assert readings.collect(now, paused=False).state == "receiving"
    assert readings.collect(now + 4.0, paused=False).state == "lost"
    for data, address in caller.hang_up(now):
        host.receive_datagram(data, address, now)
    assert readings.collect(now, paused=False).state == "call ended"


def test_the_best_of_several_calls_counts() -> None:
    host = new_host()
    silent, talking = FakeCaller(0.0), FakeCaller(0.0, address=("10.0.0.8", 99))
    now = talk(host, silent, 0.0, 1.0)
    now = talk(host, talking, now, 5.0)
    calls = list(host.streams.values())
    assert [call.is_silent(now) for call in calls] == [True, False]
    assert state_of(calls, now, had_calls=True) == "receiving"


def test_the_figures_are_the_traffics() -> None:
    host, caller = new_host(), FakeCaller(0.0)
    readings = CallStatsCollector(host)
    now = talk(host, caller, 0.0, 4.0)
    reading, traffic = readings.collect(now, paused=False), host.snapshot(now)
    assert (reading.width, reading.height, reading.points) == (PARAMETERS.width, PARAMETERS.height, PARAMETERS.points)
    assert reading.frames_received == traffic.frames_received > 30
    assert reading.raw_bytes_per_frame == 176 * 144 * 3
    assert reading.saved_percent == pytest.approx(100 - 100 / reading.ratio)
    assert reading.ratio == pytest.approx(reading.raw_bytes_per_frame / reading.bytes_per_frame)


def test_pictures_a_second_and_the_last_minute_are_remembered() -> None:
    readings = CallStatsCollector(new_host())
    for i in range(4 * HISTORY_LENGTH):
        readings.on_frame_drawn(i * HISTORY_EVERY_S / 2)
    reading = readings.collect(1e3, paused=False)
    assert reading.fps == pytest.approx(2 / HISTORY_EVERY_S)
    assert len(reading.history) == HISTORY_LENGTH
    assert reading.history_seconds == HISTORY_LENGTH * HISTORY_EVERY_S
