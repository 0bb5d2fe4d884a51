"""One receiver and many senders."""

import numpy as np
import pytest

from conf.protocol.messages import MotionFrame
from conf.protocol.session.events import Connected, Refused, SessionEnded
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.server import MAX_SESSIONS
from conf.protocol.statistics import HEADER_BYTES
from tests.support.simulated_calls import Line, Motion, World, talk
from tests.support.simulated_sessions import RECEIVER


def pitched(angle: float) -> Motion:
    """Return the talking face with its head pitched by an angle in radians."""

    def motion(timestamp: float) -> MotionFrame:
        face = talk(timestamp)
        return MotionFrame(timestamp, face.displacements, face.pose + np.array([angle, 0, 0, 0, 0, 0]))

    return motion


@pytest.mark.slow
def test_several_senders_each_with_its_own_motion() -> None:
    world = World()
    angles = [0.0, 0.3, -0.3, 0.6]
    senders = [world.call(motion=pitched(angle), line=Line(loss=0.05)) for angle in angles]
    world.run(8)
    assert len(world.receiver.streams) == len(angles)
    base = np.mean([frame.pose[0] for _, frame, _ in senders[0].shown[-400:]])
    for sender, angle in zip(senders, angles, strict=True):
        mean = np.mean([frame.pose[0] for _, frame, _ in sender.shown[-400:]])
        assert mean - base == pytest.approx(angle, abs=0.05)
    total = world.receiver.snapshot(world.now)
    streams = world.receiver.streams.values()
    assert total.frames_received == sum(leg.snapshot(world.now).frames_received for leg in streams)


def test_all_bytes_are_counted_with_their_headers() -> None:
    world = World()
    sender = world.call(line=Line(delay_s=0.0))
    world.run(5)
    data = [data for _, _, target, data in world.traffic if target == RECEIVER and data[0] == 0x94]
    assert world.stream(sender).traffic.total == pytest.approx(sum(len(d) + HEADER_BYTES for d in data), abs=100)
    assert world.receiver.snapshot(world.now).datagrams == pytest.approx(len(data), abs=1)


@pytest.mark.slow
def test_the_tenth_sender_is_refused_and_a_bye_makes_room() -> None:
    world = World()
    senders = [world.call() for _ in range(MAX_SESSIONS)]
    world.run(8)
    assert len(world.receiver.streams) == MAX_SESSIONS
    tenth = world.call()
    world.run(3)
    assert tenth.events == [Refused(Refusal.FULL, None)]
    assert len(world.receiver.streams) == MAX_SESSIONS
    received = world.receiver.snapshot(world.now).frames_received
    leaving = senders.pop()
    world.send(leaving.connection.close(world.now), leaving.address)
    leaving.motion = None
    world.senders.remove(leaving)
    world.run(1)
    assert len(world.receiver.streams) == MAX_SESSIONS - 1
    assert isinstance(world.events[-1], SessionEnded)
    assert world.receiver.report(world.now).frames_received >= received, "ended calls are still counted"
    world.senders.remove(tenth)
    late = world.call()
    world.run(3)
    assert any(isinstance(event, Connected) for event in late.events)


def test_bodies_rejected_in_ended_calls_stay_counted() -> None:
    world = World()
    sender = world.call()
    world.run(2)
    world.stream(sender).rejected = 5
    before = world.receiver.rejected
    sender.motion = None
    world.send(sender.connection.close(world.now), sender.address)
    world.run(0.2)
    assert not world.receiver.streams and world.receiver.rejected >= before >= 5


def test_junk_is_counted_and_the_call_goes_on() -> None:
    world = World()
    sender = world.call()
    world.run(3)
    before = world.receiver.rejected
    for number in range(200):
        world.receiver.receive_datagram(bytes([number]) * number, ("203.0.113.9", 9), world.now)
    assert world.receiver.rejected == world.receiver.snapshot(world.now).rejected == before + 200
    world.run(1)
    assert not world.stream(sender).is_silent(world.now)


@pytest.mark.slow
def test_a_silent_sender_is_dropped_after_half_a_minute() -> None:
    world = World()
    sender = world.call()
    world.run(2)
    sender.line.down = True
    world.run(25)
    assert len(world.receiver.streams) == 1
    world.run(10)
    assert not world.receiver.streams


def test_each_call_has_its_own_receiver_id() -> None:
    world = World()
    for _ in range(2):
        world.call()
    world.run(1)
    ids = {leg._object_receiver._receiver_id for leg in world.receiver.streams.values()}
    assert ids == {1, 2}
