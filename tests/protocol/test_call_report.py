"""Figures of present callers, of ended calls, and of all together."""

from dataclasses import replace

import pytest

from conf.protocol.address import RelayAddress
from conf.protocol.call_report import MAX_CALLERS, OTHERS, CallLog, over_time
from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from tests.support.simulated_calls import PARAMETERS, SimulatedSender, World

RAW_FRAME = PARAMETERS.width * PARAMETERS.height * 3
FIGURES = TrafficSnapshot(
    frames_received=150,
    frames_lost=2,
    frames_late=1,
    datagrams=152,
    rejected=0,
    fps=15.0,
    wire_bytes_per_frame=50.0,
    wire_kbps=6.0,
    raw_bytes_per_frame=1000,
    raw_kbps=120.0,
    ratio=20.0,
    jitter_ms=4.0,
    playout_delay_ms=30.0,
    media_bytes=MediaBytes(face=1500, voice=2250, portrait=750, overhead=3000),
)


def hang_up(world: World, sender: SimulatedSender) -> None:
    sender.motion = None
    world.send(sender.connection.close(world.now), sender.address)
    world.run(0.2)
    world.senders.remove(sender)


def test_without_a_call_there_is_no_row_and_every_figure_is_zero() -> None:
    report = World().receiver.report(1005.0)
    assert report.callers == () and set(vars(report).values()) == {0, (), MediaBytes()}


def test_bytes_are_told_by_what_they_carried_for_each_caller_and_for_all() -> None:
    log = CallLog()
    log.on_connected(1, ("203.0.113.7", 40000), 0.0)
    log.on_ended(1, FIGURES, 20.0)
    log.on_connected(2, ("203.0.113.8", 40000), 20.0)
    report = log.report({2: FIGURES}, 30.0)
    assert [row.media_bytes for row in report.callers] == [FIGURES.media_bytes] * 2
    assert report.media_bytes == FIGURES.media_bytes + FIGURES.media_bytes
    assert report.media_bytes_per_second == report.media_bytes.scaled(1 / 30)


def test_each_row_has_the_path_of_its_newest_address() -> None:
    log = CallLog()
    for session, member in enumerate("ab", 1):
        log.on_connected(session, RelayAddress("4711", member), 0.0)
    log.on_address_changed(2, ("203.0.113.8", 40000))
    running = {1: FIGURES, 2: FIGURES}
    rows = log.report(running, 30.0, path_name=lambda address: f"by {type(address).__name__}").callers
    assert [(row.caller, row.path) for row in rows] == [
        ("relay/a", "by RelayAddress"),
        ("203.0.113.8:40000", "by tuple"),
    ]
    assert [row.path for row in log.report(running, 30.0).callers] == ["", ""]


@pytest.mark.slow
def test_twelve_ended_calls_and_one_present() -> None:
    world = World()
    for _ in range(12):
        caller = world.call()
        world.run(2.0)
        hang_up(world, caller)
    present = world.call()
    world.run(6.0)
    meter, report = world.receiver.snapshot(world.now), world.receiver.report(world.now)
    alone = world.stream(present).snapshot(world.now)
    assert meter == replace(alone, rejected=meter.rejected, ratio=meter.ratio)
    assert meter.ratio == pytest.approx(alone.ratio)
    assert meter.raw_kbps == pytest.approx(RAW_FRAME * PARAMETERS.fps * 8 / 1000)  # of one caller, not of thirteen
    assert world.receiver.ended_calls == 12
    assert [caller.connected for caller in report.callers] == [False] * 12 + [True]
    assert [caller.caller for caller in report.callers] == [f"198.51.100.{n}:40000" for n in range(1, 14)]
    for row in report.callers[:12]:
        assert row.connected_s == pytest.approx(2.0, abs=0.3)
    last = report.callers[-1]
    assert last.connected_s == pytest.approx(6.0, abs=0.3) and last.frames_received == alone.frames_received
    assert last.wire_kbps == pytest.approx(alone.wire_kbps, rel=0.2)
    assert report.frames_received == sum(caller.frames_received for caller in report.callers)
    assert report.connected_s == pytest.approx(sum(caller.connected_s for caller in report.callers), abs=0.01)
    assert report.wire_kbps == pytest.approx(report.wire_bytes * 8 / 1000 / report.connected_s)
    assert 3.5 < report.wire_kbps < 12.0  # one call at a time
    assert report.ratio == pytest.approx(report.raw_kbps / report.wire_kbps)
    for row in report.callers:
        assert row.ratio == pytest.approx(row.raw_kbps / row.wire_kbps, rel=1e-3)


@pytest.mark.slow
def test_after_the_last_call_the_meter_is_zero_and_the_report_is_not() -> None:
    world = World()
    caller = world.call()
    world.run(3.0)
    hang_up(world, caller)
    meter = world.receiver.snapshot(world.now)
    assert set(vars(replace(meter, rejected=0)).values()) == {0, MediaBytes()}
    before = world.receiver.report(world.now)
    assert before.frames_received > 25 and before.wire_kbps > 3.0 and before.jitter_ms >= 0
    assert world.receiver.report(world.now + 1000.0) == before, "time without a call changes no rate"


@pytest.mark.slow
def test_a_silent_caller_keeps_its_counts_but_has_no_rate_jitter_or_delay() -> None:
    world = World()
    caller = world.call()
    world.run(3.0)
    caller.line.down = True
    world.run(6.0)
    meter = world.receiver.snapshot(world.now)
    assert meter.frames_received > 25
    assert (meter.wire_kbps, meter.raw_kbps, meter.jitter_ms, meter.playout_delay_ms) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.slow
def test_a_call_that_fell_silent_lasted_until_its_last_datagram() -> None:
    world = World()
    caller = world.call()
    world.run(3.0)
    caller.line.down = True
    world.run(35.0)
    (row,) = world.receiver.report(world.now).callers
    assert not row.connected and row.connected_s == pytest.approx(3.0, abs=0.3)


def test_calls_at_the_same_time_are_connected_once_and_their_rates_add_up() -> None:
    log = CallLog()
    log.on_connected(1, ("10.0.0.1", 1), 0.0)
    log.on_connected(2, ("10.0.0.2", 2), 0.0)
    report = log.report({1: FIGURES, 2: FIGURES}, 10.0)
    assert report.connected_s == 10.0 and [row.connected_s for row in report.callers] == [10.0, 10.0]
    assert [row.wire_kbps for row in report.callers] == [6.0, 6.0] and report.wire_kbps == 12.0
    assert report.fps == 30.0 and report.raw_kbps == 240.0 and report.ratio == 20.0


def test_a_caller_that_calls_again_from_its_address_is_one_row() -> None:
    log = CallLog()
    log.on_connected(1, ("10.0.0.1", 1), 0.0)
    log.on_ended(1, FIGURES, 10.0)
    log.on_connected(2, ("10.0.0.1", 1), 50.0)
    (row,) = log.report({2: FIGURES}, 60.0).callers
    assert row.connected and row.connected_s == 20.0 and row.frames_received == 300
    assert row.wire_bytes == 15_000 and row.wire_kbps == 6.0


def test_a_caller_that_moves_is_named_by_its_new_address() -> None:
    log = CallLog()
    log.on_connected(1, ("10.0.0.1", 1), 0.0)
    log.on_address_changed(1, ("2001:db8::1", 7, 0, 0))
    assert [row.caller for row in log.report({1: FIGURES}, 1.0).callers] == ["[2001:db8::1]:7"]


def test_too_many_callers_are_added_up_in_one_row() -> None:
    log = CallLog()
    for number in range(MAX_CALLERS + 20):
        log.on_connected(1, ("10.0.0.1", number), 10.0 * number)
        log.on_ended(1, FIGURES, 10.0 * number + 1)
    report = log.report({}, 1e6)
    assert len(report.callers) == MAX_CALLERS
    assert report.callers[0].caller == OTHERS and report.callers[0].frames_received == 21 * 150
    assert report.callers[0].connected_s == 21.0 and report.connected_s == MAX_CALLERS + 20
    assert report.frames_received == (MAX_CALLERS + 20) * 150


def test_no_time_gives_no_rate() -> None:
    still = over_time(FIGURES, 0.0)
    assert (still.fps, still.wire_kbps, still.raw_kbps, still.frames_received) == (0.0, 0.0, 0.0, 150)
