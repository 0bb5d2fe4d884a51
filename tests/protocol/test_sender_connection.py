"""A caller and a host joined by a bad network: what a call must bear."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.protocol.circuit_breaker import OPEN_AFTER_S
from conf.protocol.codec import PROFILES
from conf.protocol.congestion import RATE_LEVELS
from conf.protocol.sender_connection import RateOptions, highest_level
from conf.protocol.session.events import Connected, NoAnswer, SessionEnded, WrongCode
from tests.support.simulated_calls import RECEIVER, WRONG, End, Line, World, talk

OFF = 160  # FAPU units, mean of all points; a lone blink, which no face was trained on, costs 130 without any loss


def connected(end: End) -> bool:
    return any(isinstance(event, Connected) for event in end.events)


def decoded_errors(world: World, end: End, seconds: float) -> list[float]:
    """Run and return the mean displacement error, FAPU units, of each frame that the host decodes meanwhile."""
    errors, seen = [], set()
    for _ in range(int(seconds * 10)):
        world.run(0.1)
        for frame in world.inbound(end)._buffer._frames:
            if frame.timestamp not in seen:
                seen.add(frame.timestamp)
                truth = end.frames[min(end.frames, key=lambda t: abs(t - end.origin - frame.timestamp))]
                errors.append(float(np.linalg.norm(frame.displacements - truth.displacements, axis=1).mean()))
    return errors


def test_a_call_connects_and_its_motion_arrives() -> None:
    world = World()
    end = world.call()
    assert world.run_until(lambda: connected(end), 3) < 0.5
    errors = decoded_errors(world, end, 10)
    assert len(errors) > 100 and max(errors) < OFF
    assert world.inbound(end).rejected == 0
    now = world.now
    assert end.caller.status(now).round_trip_ms == pytest.approx(80, abs=15)
    assert end.caller.status(now).loss_percent == 0
    assert world.inbound(end).round_trip_ms == pytest.approx(80, abs=15)


def test_a_wrong_code_is_said_at_both_ends() -> None:
    world = World()
    end = world.call(code=WRONG)
    world.run(5)
    assert [type(event) for event in end.events] == [WrongCode]
    assert [type(event) for event in world.events] == [WrongCode]
    assert not world.host.streams and not end.caller.status(world.now).connected


def test_nobody_there_is_said_once() -> None:
    world = World()
    end = world.call(line=Line(down=True))
    world.run(30)
    assert [type(event) for event in end.events] == [NoAnswer]


def test_a_restarted_receiver_is_found_again() -> None:
    world = World()
    end = world.call()
    world.run(5)
    end.events.clear()
    world.restart_host()
    assert world.run_until(lambda: connected(end), 10) < 6
    world.run(2)
    assert world.inbound(end).snapshot(world.now).frames_received > 20
    assert end.shown[-1][1].timestamp == pytest.approx(end.captured - end.origin, abs=0.3)
    assert world.inbound(end).rejected == 0


def test_a_full_stop_of_the_stream_clock_between_sessions() -> None:
    """A new session counts frames from 0 again, so a receiver that knows nothing needs no clock to number them."""
    world = World()
    end = world.call()
    world.run(20)
    world.restart_host()
    world.run(12)
    assert world.inbound(end)._buffer._frames[-1].timestamp < 12


def test_a_caller_that_moves_is_followed() -> None:
    world = World()
    end = world.call()
    world.run(3)
    before = world.inbound(end)
    end.address = ("203.0.113.77", 1234)
    world.run(3)
    assert world.inbound(end) is before and not before.is_silent(world.now)
    assert end.shown[-1][1].timestamp == pytest.approx(end.captured - end.origin, abs=0.3)
    assert end.caller.status(world.now).round_trip_ms is not None


def test_silence_stops_the_sending_and_a_report_resumes_it() -> None:
    world = World()
    end = world.call()
    world.run(3)
    end.line.down = True
    world.run(OPEN_AFTER_S + 1)
    begin = world.now
    assert end.caller.status(begin).stopped
    world.run(15)
    sent = [size for at, size in end.wire if at >= begin]
    assert 0 < len(sent) < 15 and max(sent) < 100
    end.line.down = False
    assert world.run_until(lambda: not end.caller.status(world.now).stopped, 10) < 9
    world.run(2)
    assert end.shown[-1][1].timestamp == pytest.approx(end.captured - end.origin, abs=0.5)


def test_a_session_that_died_of_silence_is_replaced() -> None:
    world = World()
    end = world.call()
    world.run(3)
    end.line.down = True
    world.run(40)
    assert any(isinstance(event, SessionEnded) for event in end.events)
    end.line.down = False
    world.run(10)
    assert end.caller.status(world.now).connected
    assert not world.inbound(end).is_silent(world.now)


@settings(max_examples=8)
@given(
    st.sampled_from(["auto", *PROFILES]),
    st.floats(0.8, 12),
    st.floats(0, 0.3),
    st.sampled_from([None, 4.0, 9.0]),
)
def test_a_cap_holds_over_any_ten_seconds(profile: str, kbps: float, loss: float, restart: float | None) -> None:
    world = World(seed=kbps)
    end = world.call(line=Line(loss=loss), link=RateOptions(profile, kbps))
    for part in (restart or 0.0, 25.0):
        world.run(part)
        world.restart_host()
    end.wire += [(world.now, len(data) + 28) for data, _ in end.caller.close(world.now)]
    for begin, _ in end.wire:
        within = [size for at, size in end.wire if begin <= at < begin + 10]
        assert sum(within) <= kbps * 1000 / 8 * 10 + 1e-6
    assert end.wire


def test_the_ladder_begins_where_the_cap_allows() -> None:
    assert RATE_LEVELS[highest_level(None)].profile == "live"
    assert RATE_LEVELS[highest_level(4.5)].bundling == 2
    assert RATE_LEVELS[highest_level(1.0)].profile == "narrow"


@pytest.mark.parametrize("seed", range(4))
def test_ten_per_cent_loss_costs_only_what_was_lost(seed: int) -> None:
    clean, lossy = World(seed=seed), World(seed=seed)
    ends = clean.call(), lossy.call(line=Line(loss=0.1, jitter_s=0.01))
    ends[1].line.chance.seed(seed)
    lossy.run_until(lambda: connected(ends[1]), 10)
    clean.run_until(lambda: connected(ends[0]), 10)
    without, with_loss = decoded_errors(clean, ends[0], 20), decoded_errors(lossy, ends[1], 20)
    inbound = lossy.inbound(ends[1])
    assert inbound.rejected == 0 and inbound.missed_references == 0
    assert max(with_loss) < OFF, "no frame is wrong"
    assert np.mean(with_loss) <= 1.5 * np.mean(without)


@pytest.mark.parametrize("seed", range(3))
def test_thirty_per_cent_loss_keeps_moving(seed: int) -> None:
    world = World(seed=seed)
    end = world.call(line=Line(loss=0.3, jitter_s=0.02))
    end.line.chance.seed(seed)
    world.run_until(lambda: len(end.shown) > 0, 60)
    world.run(30)
    moving = [at for (at, a, _), (_, b, _) in pairwise(end.shown) if (a.displacements != b.displacements).any()]
    assert max(b - a for a, b in pairwise(moving)) < 1.5
    assert world.inbound(end).rejected == 0


@pytest.mark.parametrize("profile", PROFILES)
def test_after_an_outage_the_first_datagram_is_soon_seen(profile: str) -> None:
    world = World()
    end = world.call(link=RateOptions(profile))
    world.run(5)
    end.line.down = True
    world.run(2)
    end.line.down = False
    received = world.inbound(end).frames.count
    world.run_until(lambda: world.inbound(end).frames.count > received, 2)
    newest = world.inbound(end)._buffer._frames[-1].timestamp
    assert world.run_until(lambda: end.shown[-1][1].timestamp >= newest and end.shown[-1][2] < 0.1, 2) <= 0.3
    world.run(2)
    assert world.inbound(end).rejected == 0


def test_the_profile_narrows_under_loss_and_recovers() -> None:
    world = World()
    end = world.call()
    world.run(4)
    assert end.caller.status(world.now).profile == "live"
    end.line.loss = 0.25
    assert world.run_until(lambda: end.caller.status(world.now).profile == "narrow", 40) < 30
    end.line.loss = 0.0
    world.run_until(lambda: end.caller.status(world.now).frames_per_datagram == 1, 120)
    assert world.inbound(end).rejected == 0


def test_a_still_face_costs_a_keep_alive_a_second() -> None:
    world = World()
    still = talk(1.0)
    end = world.call(motion=lambda t: type(still)(t, still.displacements, still.pose))
    world.run(5)
    begin = world.now
    world.run(20)
    sent = [size for at, size in end.wire if at >= begin]
    assert len(sent) <= 24 and max(sent) < 60
    assert all(target == RECEIVER or source == RECEIVER for _, source, target, _ in world.traffic)
