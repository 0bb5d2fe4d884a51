"""A host with many callers."""

import numpy as np
import pytest

from conf.protocol.messages import MotionFrame
from conf.protocol.session.events import Connected, Refused, SessionEnded
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.server import MAX_SESSIONS
from tests.support.simulated_calls import Line, Motion, World, talk


def nodding(amount: float) -> Motion:
    def motion(timestamp: float) -> MotionFrame:
        face = talk(timestamp)
        return MotionFrame(timestamp, face.displacements, face.pose + np.array([amount, 0, 0, 0, 0, 0]))

    return motion


def test_several_callers_each_with_its_own_motion() -> None:
    world = World()
    leans = [0.0, 0.3, -0.3, 0.6]
    ends = [world.call(motion=nodding(lean), line=Line(loss=0.05)) for lean in leans]
    world.run(8)
    assert len(world.host.streams) == len(leans)
    base = np.mean([frame.pose[0] for _, frame, _ in ends[0].shown[-400:]])
    for end, lean in zip(ends, leans, strict=True):
        turned = np.mean([frame.pose[0] for _, frame, _ in end.shown[-400:]])
        assert turned - base == pytest.approx(lean, abs=0.05)
    total = world.host.snapshot(world.now)
    assert total.frames_received == sum(i.snapshot(world.now).frames_received for i in world.host.streams.values())


def test_the_tenth_is_refused_and_a_goodbye_frees_a_place() -> None:
    world = World()
    ends = [world.call() for _ in range(MAX_SESSIONS)]
    world.run(8)
    assert len(world.host.streams) == MAX_SESSIONS
    tenth = world.call()
    world.run(3)
    assert tenth.events == [Refused(Refusal.FULL, None)]
    assert len(world.host.streams) == MAX_SESSIONS
    received = world.host.snapshot(world.now).frames_received
    leaving = ends.pop()
    world._send(leaving.caller.close(world.now), leaving.address)
    leaving.motion = None
    world.ends.remove(leaving)
    world.run(1)
    assert len(world.host.streams) == MAX_SESSIONS - 1
    assert isinstance(world.events[-1], SessionEnded)
    assert world.host.snapshot(world.now).frames_received >= received, "who has left is still counted"
    world.ends.remove(tenth)
    late = world.call()
    world.run(3)
    assert any(isinstance(event, Connected) for event in late.events)


def test_junk_is_counted_and_the_call_goes_on() -> None:
    world = World()
    end = world.call()
    world.run(3)
    before = world.host.rejected
    for number in range(200):
        world.host.receive_datagram(bytes([number]) * number, ("203.0.113.9", 9), world.now)
    assert world.host.rejected == before + 200
    world.run(1)
    assert not world.inbound(end).is_silent(world.now)


def test_a_silent_caller_is_dropped_after_half_a_minute() -> None:
    world = World()
    end = world.call()
    world.run(2)
    end.line.down = True
    world.run(25)
    assert len(world.host.streams) == 1
    world.run(10)
    assert not world.host.streams
