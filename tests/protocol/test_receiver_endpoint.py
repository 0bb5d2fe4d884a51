"""One receiver and many senders."""

import numpy as np
import pytest

from conf.protocol.messages import Body, Bye, MotionFrame, RoundTripMessage
from conf.protocol.receive_leg import SILENCE_S
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import AddressChanged, Connected, Refused, SessionEnded
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.server import MAX_SESSIONS, SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.wire import encode_body
from tests.protocol.motion.test_inbound import payload
from tests.protocol.motion.test_outbound import PARAMETERS
from tests.support.simulated_calls import Line, Motion, World, talk
from tests.support.simulated_sessions import CODE, RECEIVER, SENDER, seeded


def pitched(angle: float) -> Motion:
    """Return the talking face with its head pitched by an angle in radians."""

    def motion(timestamp: float) -> MotionFrame:
        face = talk(timestamp)
        return MotionFrame(timestamp, face.displacements, face.pose + np.array([angle, 0, 0, 0, 0, 0]))

    return motion


class Direct:
    """An endpoint and senders' sessions, joined without a network."""

    def __init__(self) -> None:
        self.sessions = SessionServer(CODE, seeded("receiver"))
        self.endpoint = ReceiverEndpoint(self.sessions)

    def call(self, port: int, now: float) -> SenderSession:
        """Return the session of a new caller from 198.51.100.7 and its port."""
        caller = SenderSession(CODE, RECEIVER, seeded(port), now)
        while caller.session is None:
            for data, _ in caller.datagrams_to_send(now):
                self.endpoint.receive_datagram(data, (SENDER[0], port), now)
            for data, _ in self.endpoint.datagrams_to_send(now):
                caller.receive_datagram(data, RECEIVER, now)
        assert isinstance(caller.next_event(), Connected)
        return caller

    def send(self, caller: SenderSession, port: int, body: Body, now: float) -> int:
        """Send a body to the endpoint. Returns the size of its datagram."""
        sealed = caller.seal_body(encode_body(body))
        assert sealed
        self.endpoint.receive_datagram(sealed.datagram, (SENDER[0], port), now)
        return len(sealed.datagram) + HEADER_BYTES


def test_a_silent_caller_has_no_rate_jitter_or_delay() -> None:
    direct = Direct()
    caller = direct.call(1, 0.0)
    direct.send(caller, 1, PARAMETERS, 1.0)
    direct.send(caller, 1, payload(0), 1.0)
    (stream,) = direct.endpoint.streams.values()
    stream.reception.jitter.seconds = stream.clock.delay_s = 0.5
    for now, is_silent in ((1.0 + SILENCE_S, False), (1.1 + SILENCE_S, True)):
        figures = direct.endpoint.snapshot(now)
        assert (figures.frames_received, figures.datagrams) == (1, 2)
        assert [bool(n) for n in (figures.raw_kbps, figures.jitter_ms, figures.playout_delay_ms)] == [not is_silent] * 3
        if is_silent:
            assert (figures.raw_kbps, figures.jitter_ms, figures.playout_delay_ms) == (0.0, 0.0, 0.0)


@pytest.mark.slow
def test_the_report_holds_running_and_ended_calls_and_when_each_was_there() -> None:
    direct = Direct()
    first, second, third = (direct.call(port, float(port)) for port in (1, 2, 3))
    assert first.session is not None and second.session is not None
    size = direct.send(first, 1, payload(0), 5.0)
    for caller, port, bodies in ((first, 1, 1), (second, 2, 2)):
        for _ in range(bodies):
            sealed = caller.seal_body(b"\x02junk")
            assert sealed
            direct.endpoint.receive_datagram(sealed.datagram, (SENDER[0], port), 6.0)
    direct.send(second, 2, Bye(), 10.0)
    direct.endpoint.datagrams_to_send(30.0)
    direct.send(third, 33, RoundTripMessage(80), 35.9)  # from a new address
    for data, _ in direct.endpoint.datagrams_to_send(35.9):
        third.receive_datagram(data, RECEIVER, 35.9)
    for data, _ in third.datagrams_to_send(35.9):  # the answer to the probe
        direct.endpoint.receive_datagram(data, (SENDER[0], 33), 35.9)
    direct.endpoint.datagrams_to_send(36.0)  # the first has been silent for 30 s
    report = direct.endpoint.report(43.0)
    rows = [(row.caller, row.connected, row.connected_s) for row in report.callers]
    host = SENDER[0]
    assert rows == [(f"{host}:1", False, 5.0), (f"{host}:2", False, 8.0), (f"{host}:33", True, 40.0)]
    assert report.callers[0].wire_bytes > size and report.callers[0].frames_received == 1
    assert report.rejected == direct.endpoint.rejected == 3
    assert direct.endpoint.ended_calls == 2
    events = list(iter(direct.endpoint.next_event, None))
    assert [type(event) for event in events] == [Connected] * 3 + [SessionEnded, AddressChanged, SessionEnded]


def test_an_endpoint_begins_without_calls() -> None:
    endpoint = Direct().endpoint
    assert (endpoint.ended_calls, endpoint.rejected, endpoint.next_event(), endpoint.callers) == (0, 0, None, set())


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


@pytest.mark.slow
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


@pytest.mark.slow
def test_bodies_rejected_in_ended_calls_stay_counted() -> None:
    world = World()
    sender = world.call()
    world.run(2)
    world.stream(sender).rejected = 5
    before = world.receiver.rejected
    sender.motion = None
    world.send(sender.connection.close(world.now), sender.address)
    world.run(0.2)
    assert not world.receiver.streams and world.receiver.rejected == before == 5, "the second bye is not rejected"


@pytest.mark.slow
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


@pytest.mark.slow
def test_each_call_has_its_own_receiver_id() -> None:
    world = World()
    for _ in range(2):
        world.call()
    world.run(1)
    ids = {leg._object_receiver._receiver_id for leg in world.receiver.streams.values()}
    assert ids == {1, 2}
