import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.protocol.call_leg import CallLeg
from conf.protocol.codec.profiles import LIVE, NARROWBAND, RICH, Profile
from conf.protocol.messages import (
    Body,
    Composite,
    Feedback,
    KeepAlive,
    ParticipantMessage,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.motion.outbound import OutboundMotion
from conf.protocol.participant.state import CameraState
from conf.protocol.portrait.chunks import Chunk, decode_ack, encode_chunk
from conf.protocol.receive_leg import MAX_OBJECTS, SILENCE_S, ReceiveLeg
from conf.protocol.statistics import MediaBytes
from conf.protocol.voice.formats import GRID_MS, VoiceFormat, VoiceState
from conf.protocol.wire import VOICE_NUMBER_BITS, decode_body, encode_body
from tests.protocol.motion.test_inbound import payload
from tests.protocol.motion.test_outbound import PARAMETERS, frame

OVERHEAD = 42
OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)
# Radians. Interpolation over losses may be off by the curvature of the motion, a wrong frame by up to 0.8.
MAX_ERROR = 0.25


class Leg(ReceiveLeg):
    """A receiving half with the leg that hands it the bodies."""

    def __init__(self, receiver_id: int = 0) -> None:
        super().__init__(receiver_id)
        self.call = CallLeg(receive=self)

    def receive_body(self, data: bytes, counter: int, wire_bytes: int, now: float) -> None:
        self.call.receive_body(data, counter, wire_bytes, now)

    def bodies_to_send(self, now: float) -> list[Body]:
        bodies = [decode_body(outgoing.body) for outgoing in self.call.bodies_to_send(now)]
        return [part for body in bodies for part in (body.bodies if isinstance(body, Composite) else (body,))]


class Call:
    """Outgoing motion and a receiving half joined by a lossy link without a seal; reports each half second."""

    def __init__(self, profile: Profile = LIVE, delay: float = 0.05) -> None:
        self.outbound = OutboundMotion(PARAMETERS, profile=profile)
        self.leg = Leg()
        self.delay = delay
        self.counter = 0
        self.errors: list[float] = []
        self._reports: list[tuple[float, Body]] = []

    def run(self, frames: int, lost: list[bool], begin: float = 0.0, *, fps: float = 15) -> None:
        for i in range(frames):
            stamp = begin + i / fps
            now = 100 + stamp
            for arrival, report in [r for r in self._reports if r[0] <= now]:
                self._reports.remove((arrival, report))
                feedback = report
                assert isinstance(feedback, Feedback)
                if feedback.refresh:
                    self.outbound.drop_references()
                self.outbound.on_acknowledged(feedback.report.acknowledged())
            self.outbound.send_frame(frame(stamp), now)
            for outgoing in self.outbound.drain():
                self.outbound.on_sent(self.counter, outgoing)
                if not (lost[self.counter % len(lost)] if lost else False):
                    size = len(outgoing.body) + OVERHEAD
                    self.leg.receive_body(outgoing.body, self.counter, size, now + self.delay)
                self.counter += 1
            self._reports += [(now + 2 * self.delay, body) for body in self.leg.bodies_to_send(now + self.delay)]
            self._compare(now + self.delay)

    def _compare(self, now: float) -> None:
        playout = self.leg.motion.frame_at(now)
        if playout and playout.age_s == 0:
            truth = frame(playout.frame.timestamp)
            self.errors.append(float(abs(playout.frame.pose[1] - truth.pose[1])))


def receive(leg: Leg, *bodies: bytes, now: float = 100.0, counter: int = 0) -> None:
    for number, body in enumerate(bodies):
        leg.receive_body(body, counter + number, len(body) + OVERHEAD, now)


@pytest.mark.slow
def test_a_clean_link_delivers_everything_and_counts_it() -> None:
    call = Call()
    call.run(150, [])
    snapshot = call.leg.snapshot(100 + 10 + call.delay)
    assert (snapshot.frames_received, snapshot.frames_lost) == (call.outbound.frames_sent, 0)
    assert snapshot.frames_received > 140 and snapshot.frames_late == 0
    assert snapshot.fps == pytest.approx(14.5, rel=0.05)
    assert snapshot.raw_bytes_per_frame == 230_400
    assert snapshot.raw_kbps == pytest.approx(230_400 * 15 * 8 / 1000)
    assert snapshot.datagrams == call.counter
    assert 43 < snapshot.wire_bytes_per_frame < 60
    assert snapshot.wire_kbps == pytest.approx(snapshot.wire_bytes_per_frame * 14.5 * 8 / 1000, rel=0.08)
    assert snapshot.ratio == pytest.approx(230_400 / snapshot.wire_bytes_per_frame)
    assert snapshot.playout_delay_ms == pytest.approx(10, abs=1) and snapshot.jitter_ms < 1


def test_figures_before_anything_has_arrived_are_zero() -> None:
    snapshot = Leg().snapshot(5.0)
    assert set(vars(snapshot).values()) == {0, MediaBytes()}


def test_rates_before_the_parameters_have_arrived_are_zero_but_bytes_count() -> None:
    leg = Leg()
    receive(leg, b"\x0fjunk", b"\x0fjunk")
    snapshot = leg.snapshot(100.0)
    assert (snapshot.raw_bytes_per_frame, snapshot.raw_kbps, snapshot.ratio) == (0, 0.0, 0.0)
    assert snapshot.wire_bytes_per_frame == 2 * (5 + OVERHEAD) and snapshot.rejected == 2


@pytest.mark.slow
@settings(max_examples=15)
@given(st.lists(st.booleans(), min_size=5, max_size=40), st.sampled_from([LIVE, NARROWBAND, RICH]))
def test_no_wrong_frame_is_drawn_whatever_is_lost(losses: list[bool], profile: Profile) -> None:
    call = Call(profile)
    call.run(120, losses, fps=profile.fps)
    assert call.leg.rejected <= call.counter
    assert not call.leg.missed_references
    assert max(call.errors, default=0.0) < MAX_ERROR


@pytest.mark.slow
def test_loss_is_counted_and_playout_goes_on() -> None:
    losses = [i % 4 == 3 for i in range(40)]
    call = Call()
    call.run(150, losses)
    snapshot = call.leg.snapshot(110)
    assert snapshot.frames_lost == pytest.approx(150 / 4, abs=3)
    playout = call.leg.motion.frame_at(110.05)
    assert playout is not None and playout.frame.timestamp > 9.7


@pytest.mark.slow
def test_lost_datagrams_count_as_many_frames_as_they_held() -> None:
    call = Call(NARROWBAND)
    call.run(150, [i % 4 == 3 for i in range(40)])
    assert call.leg.snapshot(110).frames_lost == pytest.approx(150 / 4, abs=6)


@pytest.mark.slow
def test_a_receiver_that_joins_late_draws_the_face_within_a_second() -> None:
    call = Call()
    call.run(45, [True])
    call.run(20, [], begin=3.0)
    assert call.leg.motion.parameters is not None
    assert call.leg.motion.frame_at(110) is not None


@pytest.mark.slow
def test_frame_numbers_survive_an_outage_of_any_length() -> None:
    call = Call()
    call.run(30, [])
    call.run(15 * 20, [True], begin=2.0)
    call.errors.clear()
    call.run(30, [], begin=22.0)
    playout = call.leg.motion.frame_at(100 + 24)
    assert playout is not None and playout.frame.timestamp == pytest.approx(24, abs=0.3)
    assert max(call.errors[3:]) < MAX_ERROR


def test_no_face_is_passed_on_and_silence_begins_after_three_seconds() -> None:
    leg = Leg()
    assert leg.is_silent(0.0)
    receive(leg, encode_body(KeepAlive(0.0, Presence.NO_FACE)), now=10.0)
    assert leg.motion.presence is Presence.NO_FACE
    assert not leg.is_silent(10.0 + SILENCE_S) and leg.is_silent(10.1 + SILENCE_S)


def test_the_other_bodies_are_applied() -> None:
    leg = Leg()
    receive(leg, encode_body(RoundTripMessage(123)))
    assert leg.round_trip_ms == 123.0 and leg.rejected == 0


def test_the_newest_participant_tells_whether_the_portrait_may_be_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.protocol.receive_leg.ObjectReceiver.photo_percent", 40)
    leg = Leg()
    withdrawn, shown = (
        encode_body(ParticipantMessage(name, CameraState.ON, is_portrait_withdrawn=is_withdrawn))
        for name, is_withdrawn in (("Ada", True), ("Bob", False))
    )
    receive(leg, withdrawn, counter=5)
    assert (leg.name, leg.is_portrait_withdrawn, leg.portrait_percent) == ("Ada", True, None)
    receive(leg, shown, counter=4)
    assert leg.name == "Ada" and leg.is_portrait_withdrawn
    receive(leg, shown, counter=6)
    assert (leg.name, leg.is_portrait_withdrawn, leg.portrait_percent) == ("Bob", False, 40)


def test_the_newest_datagram_tells_whether_the_camera_is_on() -> None:
    leg = Leg()
    off, on = (encode_body(ParticipantMessage("Ada", camera)) for camera in (CameraState.OFF, CameraState.ON))
    assert (leg.name, leg.camera, leg.portrait_percent) == ("", CameraState.ON, None)
    receive(leg, off, counter=5)
    assert (leg.name, leg.camera, leg.head) == ("Ada", CameraState.OFF, 0)
    receive(leg, encode_body(payload(0)), counter=4)
    assert leg.camera is CameraState.OFF, "the frame is older"
    receive(leg, encode_body(KeepAlive(1.0, Presence.NO_FACE)), counter=6)
    assert leg.camera is CameraState.NO_FACE
    receive(leg, encode_body(payload(1)), counter=7)
    assert leg.camera is CameraState.ON
    receive(leg, off, counter=6)
    assert leg.camera is CameraState.ON
    receive(leg, off, counter=8)
    receive(leg, on, counter=9)
    assert leg.camera is CameraState.ON and leg.rejected == 0


def test_voice_is_received_at_the_stream_time_and_state_of_its_counter() -> None:
    leg = Leg()
    assert not leg.refresh_needed and leg.round_trip_ms is None
    for body in (VoiceFormatMessage(2, OPUS), VoiceStateMessage(VoiceState.SILENT, 55)):
        assert leg.receive(body, 4, 100.0) is None
    assert (leg.voice.state, leg.voice.noise_level) == (VoiceState.SILENT, 55)
    assert leg.receive(VoicePayload(3, True, 2, b"voice"), 5, 100.0) == 3 * GRID_MS / 1000 + 0.06
    assert (leg.voice.format, leg.voice.state) == (OPUS, VoiceState.TALKING)
    leg.receive(VoiceStateMessage(VoiceState.OFF, 60), 3, 100.1)
    assert leg.voice.state is VoiceState.TALKING, "a state of an earlier datagram is old"
    leg.receive(VoiceStateMessage(VoiceState.OFF, 60), 6, 100.1)
    assert (leg.voice.state, leg.voice.noise_level) == (VoiceState.OFF, 60)
    assert [frame.data for frame in leg.voice.frames_until(10.0)] == [b"voice"]


def test_voice_and_motion_share_the_playout_clock_and_the_sender_s() -> None:
    leg = Leg()
    receive(leg, encode_body(KeepAlive(600.0, Presence.FACE)), encode_body(VoiceFormatMessage(0, OPUS)))
    low_bits = (600_000 // GRID_MS + 5) % (1 << VOICE_NUMBER_BITS)
    end = leg.receive(VoicePayload(low_bits, True, 0, b"voice"), 3, 100.1)
    assert end == pytest.approx(600.0 + 5 * GRID_MS / 1000 + 0.06), "the keep-alive told the time"
    assert leg.voice.clock is leg.motion.buffer.clock is leg.clock


def test_figures_are_in_milliseconds_and_lost_frames_in_proportion_to_the_datagrams() -> None:
    leg = Leg()
    receive(leg, encode_body(Composite((PARAMETERS, payload(0)))))
    leg.reception.jitter.seconds = 0.25
    leg.clock.delay_s = 0.5
    receive(leg, encode_body(RoundTripMessage(1)), counter=5, now=101.0)
    snapshot = leg.snapshot(101.0)
    assert (snapshot.jitter_ms, snapshot.playout_delay_ms) == (250.0, 500.0)
    assert snapshot.frames_lost == leg.reception.lost == 4
    assert snapshot.wire_kbps == pytest.approx(leg.traffic.rates(101.0)[0] / 125)


def test_chunks_become_objects_alone_and_beside_motion_and_are_acknowledged() -> None:
    leg = Leg(receiver_id=7)
    first, second = (PortraitChunk(encode_chunk(Chunk(3, 80, i, 100, bytes([i]) * (80 - 60 * i)))) for i in (0, 1))
    receive(leg, encode_body(first))
    assert not leg.received_objects and leg.motion.frames.count == 0
    receive(leg, encode_body(Composite((payload(0), second))), counter=1)
    assert list(leg.received_objects) == [bytes(80) + b"\1" * 20] and leg.motion.frames.count == 1
    report, ack = leg.bodies_to_send(101.0)
    assert isinstance(report, Feedback) and report.report.highest == 1
    assert isinstance(ack, PortraitAck)
    assert (decode_ack(ack.data).receiver_id, decode_ack(ack.data).complete) == (7, (3,))


def test_objects_that_nobody_uses_are_bounded() -> None:
    leg = Leg()
    for number in range(MAX_OBJECTS + 5):
        receive(leg, encode_body(PortraitChunk(encode_chunk(Chunk(number, 4, 0, 2, number.to_bytes(2))))))
    assert [int.from_bytes(data) for data in leg.received_objects] == list(range(5, MAX_OBJECTS + 5))


def test_reports_come_twice_a_second_and_only_after_something_new() -> None:
    leg = Leg()
    assert leg.bodies_to_send(100.0) == []
    times = []
    for step in range(40):
        now = 100 + step / 10
        if step < 20:
            receive(leg, encode_body(RoundTripMessage(1)), now=now - 0.05, counter=step)
        if leg.bodies_to_send(now):
            times.append(now)
    assert times == pytest.approx([100.0, 100.5, 101.0, 101.5, 102.0])


@pytest.mark.slow
@given(st.lists(st.binary(max_size=40), max_size=20))
def test_bad_bodies_are_counted_and_never_raise(bodies: list[bytes]) -> None:
    call = Call()
    call.run(5, [])
    before = call.leg.snapshot(101).frames_received
    receive(call.leg, *(b"\x0f\0\0" + body for body in bodies), now=101, counter=100)
    assert call.leg.rejected == len(bodies)
    assert call.leg.snapshot(101).frames_received == before


@pytest.mark.slow
def test_a_missing_reference_is_requested_once_and_never_guessed() -> None:
    call = Call()
    call.run(30, [])
    fresh = Leg()
    call.leg = fresh
    # The new receiver gets the parameters, and motion predicted from what it never had.
    call.outbound._acknowledged_parameters = None
    call.run(30, [], begin=2.0)
    assert fresh.missed_references and not fresh.rejected
    assert fresh.snapshot(105).frames_received > 10
    assert max(call.errors) < MAX_ERROR


def test_a_refresh_is_requested_in_one_report_and_an_undecodable_body_is_not_acknowledged() -> None:
    sender = OutboundMotion(PARAMETERS)
    bodies = []
    for counter in range(12):
        sender.send_frame(frame(counter / 15), 0.0)
        for outgoing in sender.drain():
            sender.on_sent(counter, outgoing)
            bodies.append(outgoing.body)
        sender.on_acknowledged([counter])
    leg = Leg()
    predicted = bodies[-1]
    receive(leg, encode_body(RoundTripMessage(1)), predicted)
    (feedback,) = leg.bodies_to_send(100.0)
    assert isinstance(feedback, Feedback)
    assert feedback.refresh and feedback.report.highest == 0 and leg.missed_references == 1
    receive(leg, encode_body(RoundTripMessage(1)), now=101.0, counter=2)
    (feedback,) = leg.bodies_to_send(101.0)
    assert isinstance(feedback, Feedback)
    assert not feedback.refresh and feedback.report.lost == 0


def test_a_participant_tells_which_head_it_has_chosen() -> None:
    leg = Leg()
    receive(leg, encode_body(ParticipantMessage("", CameraState.ON, head=4)), counter=0)
    assert (leg.name, leg.head) == ("", 4)
