"""Whole calls over a bad network."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.protocol.codec.profiles import PROFILES
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    MotionFrame,
    MotionPayload,
    PortraitChunk,
    RoundTripMessage,
    SingleBody,
    StreamParameters,
)
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import BodyReceived, Connected, NoAnswer, SessionEnded, WrongCode
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.wire import decode_body, encode_body
from tests.protocol.motion.test_outbound import PARAMETERS
from tests.support.simulated_calls import Line, SimulatedSender, World, talk
from tests.support.simulated_sessions import CODE, RECEIVER, SENDER, WRONG, seeded

# FAPU units, mean of all points. A single blink, on which the codec was not trained, gives 130 without any loss.
MAX_ERROR = 160


def connected(sender: SimulatedSender) -> bool:
    return any(isinstance(event, Connected) for event in sender.events)


def decoded_errors(world: World, sender: SimulatedSender, seconds: float) -> list[float]:
    """Run and return the mean displacement error, FAPU units, of each frame that the receiver decodes meanwhile."""
    errors, compared = [], set()
    for _ in range(int(seconds * 10)):
        world.run(0.1)
        for frame in world.stream(sender).motion.buffer._frames:
            if frame.timestamp not in compared:
                compared.add(frame.timestamp)
                truth = sender.frames[min(sender.frames, key=lambda t: abs(t - sender.origin - frame.timestamp))]
                errors.append(float(np.linalg.norm(frame.displacements - truth.displacements, axis=1).mean()))
    return errors


class Direct:
    """A connection and the receiver's sessions, joined without a network."""

    def __init__(self, portrait: ObjectSender | None = None) -> None:
        self.server = SessionServer(CODE, seeded("receiver"))
        session = SenderSession(CODE, RECEIVER, seeded("sender"), 0.0)
        self.connection = SenderConnection(session, PARAMETERS, 0.0, portrait=portrait)
        self.session = session
        self.sizes: list[int] = []
        while not self.server.sessions:
            self.exchange(0.0)

    def exchange(self, now: float) -> list[SingleBody]:
        """Carry what is due in both directions. Returns the bodies received."""
        for data, _ in self.connection.datagrams_to_send(now):
            self.sizes.append(len(data) + HEADER_BYTES)
            self.server.receive_datagram(data, SENDER, now)
        for data, _ in self.server.datagrams_to_send(now):
            self.connection.receive_datagram(data, RECEIVER, now)
        received: list[SingleBody] = []
        while event := self.server.next_event():
            if isinstance(event, BodyReceived):
                body = decode_body(event.body)
                received += body.bodies if isinstance(body, Composite) else (body,)
        return received

    def reply(self, body: Body, now: float) -> int:
        """Send a body to the connection. Returns the size of its datagram."""
        (session,) = self.server.sessions
        sealed = self.server.seal_body(session, encode_body(body))
        assert sealed
        self.connection.receive_datagram(sealed.datagram, RECEIVER, now)
        return len(sealed.datagram) + HEADER_BYTES


def test_motion_portrait_and_traffic_of_a_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    portrait = ObjectSender()
    portrait.send_object(0, bytes(500), priority=0)
    call, counted = Direct(portrait), list[tuple[int, float]]()
    assert [type(event) for event in iter(call.connection.next_event, None)] == [Connected]
    monkeypatch.setattr(call.connection._send.budget, "on_datagrams_sent", lambda *args: counted.append(args))
    call.connection.send_frame(talk(0.0), 1.0)
    before = len(call.sizes)
    assert [type(body) for body in call.exchange(1.0)] == [StreamParameters, MotionPayload, PortraitChunk]
    assert counted == [(sum(call.sizes[before:]), 1.0)]
    closing = [len(data) + HEADER_BYTES for data, _ in call.connection.close(2.0)]
    assert call.connection.traffic.total == sum(call.sizes) + sum(closing)


def test_only_a_report_acknowledges(monkeypatch: pytest.MonkeyPatch) -> None:
    call, acknowledged = Direct(), list[int]()
    monkeypatch.setattr(call.session, "acknowledge", acknowledged.append)
    call.reply(RoundTripMessage(80), 1.0)
    call.reply(Feedback(Report(0, 0, 0, 0, 0), refresh=False), 2.0)
    assert acknowledged == [0]


def test_a_session_that_ends_stops_sending() -> None:
    call = Direct()
    assert call.connection.status(1.0).connected and call.session._active
    call.session._active.sealing_key.counter = 1 << 32
    call.connection.send_frame(talk(0.0), 1.0)
    call.connection.datagrams_to_send(1.0)
    call.connection.datagrams_to_send(1.1)
    assert not call.connection.status(1.1).connected
    assert [type(event) for event in iter(call.connection.next_event, None)] == [Connected, SessionEnded]


def test_everything_sent_goes_to_the_sending_half(monkeypatch: pytest.MonkeyPatch) -> None:
    connection, calls = Direct().connection, list[object]()
    packet = VoicePacket(1.0, VoiceFormat("opus", 9000, 60, 1, fixed_size=False), (b"a",))
    for name in ("send_no_face", "send_voice", "set_voice_state"):
        monkeypatch.setattr(connection._send, name, lambda *args, **options: calls.append((*args, options)))
    connection.send_no_face(5.0, 6.0)
    connection.send_voice(packet, 7.0)
    connection.set_voice_state(VoiceState.SILENT, 8.0, noise_level=50)
    connection.set_voice_state(VoiceState.OFF, 9.0)
    assert calls == [
        (5.0, 6.0, {}),
        (packet, 7.0, {}),
        (VoiceState.SILENT, 8.0, {"noise_level": 50}),
        (VoiceState.OFF, 9.0, {"noise_level": 127}),
    ]


@pytest.mark.slow
def test_a_call_connects_and_its_motion_arrives() -> None:
    world = World()
    sender = world.call()
    assert world.run_until(lambda: connected(sender), 3) < 0.5
    errors = decoded_errors(world, sender, 10)
    assert len(errors) > 100 and max(errors) < MAX_ERROR
    assert world.stream(sender).rejected == 0
    status = sender.connection.status(world.now)
    assert status.round_trip_ms == pytest.approx(80, abs=15)
    assert (status.loss_percent, status.stopped, status.jitter_ms) == (0, False, pytest.approx(10, abs=10))
    assert world.stream(sender).round_trip_ms == pytest.approx(80, abs=15)
    assert sender.connection.traffic.total == sum(size for _, size in sender.wire)


def test_a_wrong_code_is_reported_on_both_sides() -> None:
    world = World()
    sender = world.call(code=WRONG)
    world.run(5)
    assert [type(event) for event in sender.events] == [WrongCode]
    assert [type(event) for event in world.events] == [WrongCode]
    assert not world.receiver.streams and not sender.connection.status(world.now).connected


def test_no_answer_is_reported_once() -> None:
    world = World()
    sender = world.call(line=Line(down=True))
    world.run(30)
    assert [type(event) for event in sender.events] == [NoAnswer]


@pytest.mark.slow
def test_the_sender_reconnects_to_a_restarted_receiver() -> None:
    world = World()
    sender = world.call()
    world.run(5)
    sender.events.clear()
    world.restart_receiver()
    assert world.run_until(lambda: connected(sender), 10) < 6
    world.run(2)
    assert world.stream(sender).snapshot(world.now).frames_received > 15
    assert sender.shown[-1][1].timestamp == pytest.approx(sender.captured - sender.origin, abs=0.3)
    assert world.stream(sender).rejected == 0


@pytest.mark.slow
def test_the_stream_clock_starts_again_in_each_session() -> None:
    """A new session counts frames from 0 again, so that a receiver that knows nothing needs no clock to number them."""
    world = World()
    sender = world.call()
    world.run(20)
    world.restart_receiver()
    world.run(12)
    newest = world.stream(sender).motion.buffer.newest
    assert newest is not None and newest < 12


@pytest.mark.slow
def test_a_sender_whose_address_changes_keeps_its_session() -> None:
    world = World()
    sender = world.call()
    world.run(3)
    before = world.stream(sender)
    sender.address = ("203.0.113.77", 1234)
    world.run(3)
    assert world.stream(sender) is before and not before.is_silent(world.now)
    assert sender.shown[-1][1].timestamp == pytest.approx(sender.captured - sender.origin, abs=0.3)
    assert sender.connection.status(world.now).round_trip_ms is not None


@pytest.mark.slow
def test_sending_stops_without_reports_and_resumes_with_the_first() -> None:
    world = World()
    sender = world.call()
    world.run(3)
    sender.line.down = True
    world.run(OPEN_AFTER_S + 1)
    begin = world.now
    assert sender.connection.status(begin).stopped
    world.run(15)
    sent = [size for at, size in sender.wire if at >= begin]
    assert 0 < len(sent) < 15 and max(sent) < 100
    sender.line.down = False
    assert world.run_until(lambda: not sender.connection.status(world.now).stopped, 10) < 9
    world.run(2)
    assert sender.shown[-1][1].timestamp == pytest.approx(sender.captured - sender.origin, abs=0.5)


@pytest.mark.slow
def test_a_session_that_ended_by_silence_is_replaced() -> None:
    world = World()
    sender = world.call()
    world.run(3)
    sender.line.down = True
    world.run(40)
    assert any(isinstance(event, SessionEnded) for event in sender.events)
    status = sender.connection.status(world.now)
    assert not status.connected and not status.stopped
    sender.line.down = False
    world.run(10)
    assert sender.connection.status(world.now).connected
    assert not world.stream(sender).is_silent(world.now)


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(["auto", *PROFILES]), st.floats(0.8, 12), st.floats(0, 0.3), st.sampled_from([None, 4.0, 9.0]))
def test_a_limit_holds_over_any_ten_seconds(profile: str, kbps: float, loss: float, restart: float | None) -> None:
    world = World(seed=kbps)
    sender = world.call(line=Line(loss=loss), rate=RateOptions(profile, kbps))
    for part in (restart or 0.0, 25.0):
        world.run(part)
        world.restart_receiver()
    sender.wire += [(world.now, len(data) + HEADER_BYTES) for data, _ in sender.connection.close(world.now)]
    for begin, _ in sender.wire:
        within = [size for at, size in sender.wire if begin <= at < begin + 10]
        assert sum(within) <= kbps * 1000 / 8 * 10 + 1e-6
    assert sender.wire


def test_a_limit_also_drops_handshake_datagrams() -> None:
    sender = SimulatedSender(0.0, rate=RateOptions(kbps=0.064))
    assert sender.datagrams_to_send(0.0) == [] == sender.datagrams_to_send(100.0)
    assert SimulatedSender(0.0, rate=RateOptions(kbps=0.069)).datagrams_to_send(0.0) != []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_ten_per_cent_loss_costs_only_what_was_lost(seed: int) -> None:
    clean, lossy = World(seed=seed), World(seed=seed)
    senders = clean.call(), lossy.call(line=Line(loss=0.1, jitter_s=0.01))
    senders[1].line.generator.seed(seed)
    lossy.run_until(lambda: connected(senders[1]), 10)
    clean.run_until(lambda: connected(senders[0]), 10)
    without, with_loss = decoded_errors(clean, senders[0], 20), decoded_errors(lossy, senders[1], 20)
    stream = lossy.stream(senders[1])
    assert stream.rejected == 0 and stream.missed_references == 0
    assert max(with_loss) < MAX_ERROR, "no frame is wrong"
    assert np.mean(with_loss) <= 1.5 * np.mean(without)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_thirty_per_cent_loss_keeps_moving(seed: int) -> None:
    world = World(seed=seed)
    sender = world.call(line=Line(loss=0.3, jitter_s=0.02))
    sender.line.generator.seed(seed)
    world.run_until(lambda: len(sender.shown) > 0, 60)
    world.run(30)
    moving = [at for (at, a, _), (_, b, _) in pairwise(sender.shown) if (a.displacements != b.displacements).any()]
    assert max(b - a for a, b in pairwise(moving)) < 1.5
    assert world.stream(sender).rejected == 0


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES)
def test_after_an_outage_the_first_datagram_is_soon_drawn(profile: str) -> None:
    world = World()
    sender = world.call(rate=RateOptions(profile))
    world.run(5)
    sender.line.down = True
    world.run(2)
    sender.line.down = False
    motion = world.stream(sender).motion
    received = motion.frames.count
    world.run_until(lambda: motion.frames.count > received, 2)
    newest = motion.buffer.newest
    assert newest is not None
    assert world.run_until(lambda: sender.shown[-1][1].timestamp >= newest and sender.shown[-1][2] < 0.1, 2) <= 0.3
    world.run(2)
    assert world.stream(sender).rejected == 0


@pytest.mark.slow
def test_the_rate_level_falls_under_loss_and_recovers() -> None:
    world = World()
    sender = world.call()
    world.run(4)
    assert sender.connection.status(world.now).profile == "live"
    sender.line.loss = 0.25
    assert world.run_until(lambda: sender.connection.status(world.now).profile == "narrow", 40) < 30
    assert sender.connection.outbound.profile.name == "narrow"
    sender.line.loss = 0.0
    world.run_until(lambda: sender.connection.status(world.now).frames_per_datagram == 1, 120)
    assert world.stream(sender).rejected == 0


@pytest.mark.slow
def test_a_still_face_costs_a_keep_alive_a_second() -> None:
    world = World()
    still = talk(1.0)
    sender = world.call(motion=lambda t: MotionFrame(t, still.displacements, still.pose))
    world.run(5)
    begin = world.now
    world.run(20)
    sent = [size for at, size in sender.wire if at >= begin]
    assert len(sent) <= 24 and max(sent) < 60
    assert all(target == RECEIVER or source == RECEIVER for _, source, target, _ in world.traffic)


@pytest.mark.slow
def test_closing_sends_two_short_datagrams_that_end_the_call() -> None:
    world = World()
    sender = world.call()
    world.run(2)
    last = sender.connection.close(world.now)
    assert len(last) == 2 and {len(data) for data, _ in last} <= {len(encode_body(Bye())) + n for n in (14, 15, 16)}
    sender.motion = None
    world.send(last[1:], sender.address)
    world.run(0.2)
    assert not world.receiver.streams


@pytest.mark.slow
def test_counters_are_sent_short_once_the_receiver_has_acknowledged_them() -> None:
    world = World()
    sender = world.call()
    world.run(15)
    newest = [data for _, source, _, data in world.traffic if source == sender.address][-1]
    assert sender.session._active is not None and sender.session._active.sealing_key.counter > 150
    assert newest[3] < 0x80
