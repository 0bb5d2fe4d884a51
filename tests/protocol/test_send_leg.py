"""The sending half without a session: bodies out, reports in."""

import pytest

from conf.protocol import send_leg
from conf.protocol.call_leg import CallLeg
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    KeepAlive,
    MotionPayload,
    ParticipantMessage,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    StreamParameters,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.participant.state import CameraState
from conf.protocol.portrait.chunks import Ack, encode_ack
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.send_leg import SendLeg
from conf.protocol.voice.formats import GRID_MS, VoicePacket, VoiceState
from conf.protocol.wire import PARTICIPANT, VOICE_BIT, decode_body, encode_body, split_bodies
from tests.protocol.motion.test_outbound import PARAMETERS, frame


class Leg(SendLeg):
    """A sending half with the leg that hands it the bodies."""

    def __init__(
        self, now: float = 0.0, rate: RateOptions | None = None, portrait: ObjectSender | None = None, name: str = ""
    ) -> None:
        super().__init__(PARAMETERS, now, rate=rate, portrait=portrait, name=name)
        self.call = CallLeg(send=self)

    def receive_body(self, data: bytes, now: float) -> int | None:
        return self.call.receive_body(data, 0, 0, now)


def started(rate: RateOptions | None = None, portrait: ObjectSender | None = None) -> Leg:
    leg = Leg(rate=rate, portrait=portrait)
    leg.start(0.0)
    return leg


def portrait(size: int = 5000) -> ObjectSender:
    made = ObjectSender()
    made.send_object(0, bytes(size), priority=0)
    return made


def sent(leg: SendLeg, now: float) -> list[Body]:
    return [decode_body(outgoing.body) for outgoing in leg.bodies_to_send(now)]


def feedback(highest: int, *, missing: int = 0, lost: int = 0, refresh: bool = False) -> bytes:
    return encode_body(Feedback(Report(highest, missing, lost, 5, 0), refresh))


def acknowledge_all(leg: Leg, now: float, counter: int = 0, rtt_s: float = 0.0) -> int:
    """Send what is due, and acknowledge it a round trip later. Returns the next counter."""
    for outgoing in leg.bodies_to_send(now):
        leg.on_sent(counter, outgoing, now)
        counter += 1
    leg.receive_body(feedback(counter - 1), now + rtt_s)
    return counter


def test_nothing_is_sent_before_the_session_starts_and_after_it_stops() -> None:
    leg = Leg(portrait=portrait())
    leg.send_frame(frame(0.0), 0.0)
    leg.send_no_face(0.1, 0.1)
    assert sent(leg, 0.2) == [] and not leg.status(0.2).connected
    leg.start(1.0)
    leg.send_frame(frame(1.0), 1.0)
    assert [type(body) for body in sent(leg, 1.0)] == [StreamParameters, MotionPayload, PortraitChunk]
    assert leg.status(1.0).connected
    leg.stop()
    leg.send_frame(frame(2.0), 2.0)
    assert sent(leg, 2.0) == [] and not leg.status(2.0).connected


def test_no_face_is_reported() -> None:
    leg = started()
    leg.send_no_face(5.0, 5.0)
    assert sent(leg, 5.0)[1] == KeepAlive(0.0, Presence.NO_FACE)


def test_without_reports_only_probes_are_sent() -> None:
    leg = started()
    leg.send_frame(frame(7.0), 0.0)
    sent(leg, 0.0)
    leg.send_frame(frame(17.5), OPEN_AFTER_S)
    assert leg.status(OPEN_AFTER_S).stopped
    assert sent(leg, OPEN_AFTER_S) == [KeepAlive(10.5, Presence.FACE)]
    assert sent(leg, OPEN_AFTER_S + 0.5) == []
    leg.receive_body(feedback(0), OPEN_AFTER_S + 0.6)
    assert not leg.status(OPEN_AFTER_S + 0.6).stopped
    leg.send_frame(frame(18.0), OPEN_AFTER_S + 0.7)
    assert MotionPayload in map(type, sent(leg, OPEN_AFTER_S + 0.7))


def test_a_new_session_repeats_parameters_and_portrait() -> None:
    leg = started(portrait=portrait(10))
    leg.send_frame(frame(0.0), 0.0)
    counter = acknowledge_all(leg, 0.0)
    leg.receive_body(encode_body(PortraitAck(encode_ack(Ack(1, (1,), ())))), 0.1)
    leg.send_frame(frame(5.0), 5.0)
    assert [type(body) for body in sent(leg, 5.0)] == [MotionPayload]
    leg.start(6.0)
    leg.send_frame(frame(6.0), 6.0)
    assert [type(body) for body in sent(leg, 6.0)] == [StreamParameters, MotionPayload, PortraitChunk]
    assert counter == 3


def test_bodies_beyond_the_limit_are_dropped() -> None:
    leg = started(RateOptions(kbps=1.0))  # bursts of 96 B
    leg.send_frame(frame(0.0), 0.0)
    assert [type(decode_body(outgoing.body)) for outgoing in leg.call.bodies_to_send(0.0)] == [StreamParameters]
    leg = started(RateOptions(kbps=1.2))
    assert [len(leg.call.closing_bodies(0.0)) for _ in range(2)] == [2, 0]
    assert [decode_body(outgoing.body) for outgoing in leg.closing_bodies()] == [Bye(), Bye()]


def test_a_report_tells_the_newest_counter_and_other_bodies_tell_none() -> None:
    leg = started()
    assert leg.receive_body(feedback(17), 0.1) == 17
    for body in (encode_body(PortraitAck(encode_ack(Ack(1, (), ())))), encode_body(Bye()), b"", b"\x02junk"):
        assert leg.receive_body(body, 0.1) is None
    with_portrait = started(portrait=portrait())
    assert with_portrait.receive_body(encode_body(PortraitAck(b"junk" * 40)), 0.1) is None


@pytest.mark.slow
def test_acknowledged_frames_are_predicted_from_until_a_refresh_is_requested() -> None:
    def size(refresh: bool) -> int:
        leg, counter = started(), 0
        for number in range(30):
            leg.send_frame(frame(number / 15), number / 15)
            counter = acknowledge_all(leg, number / 15, counter)
        leg.receive_body(feedback(counter - 1, refresh=refresh), 2.0)
        leg.send_frame(frame(2.0), 2.0)
        return sum(len(outgoing.body) for outgoing in leg.bodies_to_send(2.0) if outgoing.frame_numbers)

    assert 0 < size(refresh=False) < size(refresh=True)


@pytest.mark.slow
def test_the_round_trip_is_sent_when_it_has_changed_and_at_most_every_ten_seconds() -> None:
    leg, counter, told = started(), 0, []
    for step in range(80):
        now = 0.5 * step
        rtt_s = 0.1 if step < 40 else 0.2
        leg.send_frame(frame(now), now)
        bodies = leg.bodies_to_send(now)
        told += [(now, body) for o in bodies if isinstance(body := decode_body(o.body), RoundTripMessage)]
        for outgoing in bodies:
            leg.on_sent(counter, outgoing, now)
            counter += 1
        leg.receive_body(feedback(counter - 1), now + rtt_s)
    assert told[0] == (0.5, RoundTripMessage(100))
    assert len(told) == 3 and all(body.milliseconds > 125 for _, body in told[1:])
    assert told[2][0] - told[1][0] >= send_leg.ROUND_TRIP_INTERVAL_S
    assert leg.status(40.0).round_trip_ms == pytest.approx(200, abs=3)


@pytest.mark.parametrize(("rtt_s", "is_sent"), [(0.0049, False), (0.0051, True)])
def test_a_round_trip_below_5_ms_is_not_sent(rtt_s: float, is_sent: bool) -> None:
    leg = started()
    leg.send_frame(frame(0.0), 0.0)
    acknowledge_all(leg, 0.0, rtt_s=rtt_s)
    assert (RoundTripMessage(5) in sent(leg, 1.0)) == is_sent


@pytest.mark.parametrize(("change", "is_sent"), [(0.24, False), (0.26, True), (-0.24, False), (-0.26, True)])
def test_a_round_trip_is_sent_again_if_it_changes_by_a_quarter(change: float, is_sent: bool) -> None:
    leg = started()
    leg.budget.round_trip.smoothed_s = 0.1
    assert sent(leg, 1.0) == [RoundTripMessage(100)]
    leg.budget.restart(12.0)
    leg.budget.round_trip.smoothed_s = 0.1 * (1 + change)
    assert (sent(leg, 1.0 + send_leg.ROUND_TRIP_INTERVAL_S) != []) == is_sent


def test_chunks_share_the_datagram_of_the_last_motion() -> None:
    leg = started(portrait=portrait())
    leg.send_frame(frame(0.0), 0.0)
    (outgoing,) = leg.call.bodies_to_send(0.0)
    body = decode_body(outgoing.body)
    assert isinstance(body, Composite) and outgoing.frame_numbers == (0,)
    assert [type(part) for part in body.bodies] == [StreamParameters, MotionPayload, PortraitChunk]
    plain = started()
    plain.send_frame(frame(0.0), 0.0)
    (alone,) = plain.call.bodies_to_send(0.0)
    assert leg.budget.chunks.bytes_sent == len(outgoing.body) - len(alone.body) == 2 + 82


def test_a_chunk_without_motion_is_sent_alone_after_a_wait() -> None:
    leg = started(portrait=portrait())
    leg.send_frame(frame(0.0), 0.0)
    sent(leg, 0.0)
    assert leg.budget.chunks.in_startup
    assert sent(leg, send_leg.STARTUP_PIGGYBACK_WAIT_S - 0.01) == []
    assert [type(body) for body in sent(leg, send_leg.STARTUP_PIGGYBACK_WAIT_S)] == [PortraitChunk]
    assert leg.budget.chunks.bytes_sent == 82 + 2 + 82 + 47
    assert sent(leg, send_leg.STARTUP_PIGGYBACK_WAIT_S + 0.01) == []


def test_after_startup_the_wait_is_longer() -> None:
    leg = started(portrait=portrait())
    leg.budget.chunks._startup_left = 0
    leg.send_frame(frame(0.0), 0.0)
    sent(leg, 0.0)
    assert sent(leg, send_leg.MAX_PIGGYBACK_WAIT_S - 0.01) == []
    assert [type(body) for body in sent(leg, send_leg.MAX_PIGGYBACK_WAIT_S)] == [PortraitChunk]


@pytest.mark.parametrize(("size", "kinds"), [(255, [Composite]), (256, [MotionPayload, PortraitChunk])])
def test_motion_too_long_for_its_length_byte_is_sent_without_a_chunk(size: int, kinds: list[type]) -> None:
    leg = started(portrait=portrait())
    motion = MotionPayload(0, bytes(size - 1))
    leg.motion._queue.append(OutgoingBody(encode_body(motion), (0,)))
    assert [type(decode_body(outgoing.body)) for outgoing in leg.call.bodies_to_send(0.1)] == kinds


def test_an_ack_of_a_new_receiver_begins_the_startup_again() -> None:
    leg = started(portrait=portrait())
    leg.budget.chunks._startup_left = 0
    for receiver_id, in_startup in ((1, False), (1, False), (2, True)):
        leg.receive_body(encode_body(PortraitAck(encode_ack(Ack(receiver_id, (), ())))), 0.1)
        assert leg.budget.chunks.in_startup == in_startup


def test_the_status_before_and_after_the_first_reports() -> None:
    leg = started()
    status = leg.status(0.0)
    assert (status.profile, status.frames_per_datagram, status.stopped) == ("live", 1, False)
    assert (status.round_trip_ms, status.loss_percent, status.jitter_ms) == (None, None, None)
    leg.receive_body(feedback(0), 0.5)
    leg.receive_body(feedback(39, lost=10), 1.0)
    status = leg.status(1.0)
    assert (status.jitter_ms, status.loss_percent) == (5.0, pytest.approx(100 * 10 / 39))


def test_the_profile_follows_the_rate_level() -> None:
    leg, highest = started(), 0
    for step in range(60):
        highest += 20
        leg.receive_body(feedback(highest, lost=6 * step), 0.5 * step)
    assert leg.motion.profile.name == leg.status(30.0).profile == "narrow"
    assert started(RateOptions("rich")).motion.profile.name == "rich"
    assert started(RateOptions(kbps=4.5)).status(0.0).frames_per_datagram == 2


def test_a_session_that_starts_late_is_not_stopped() -> None:
    leg = Leg()
    leg.start(2 * OPEN_AFTER_S)
    assert leg.status(2 * OPEN_AFTER_S).connected and not leg.status(2 * OPEN_AFTER_S).stopped


def talking(kbps: float | None = None, *, portrait: ObjectSender | None = None) -> Leg:
    leg = started(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), portrait)
    say(leg, 0.0)
    return leg


def say(leg: Leg, now: float, timestamp: float | None = None) -> None:
    voice_format = leg.voice_format or pytest.fail("there is no voice")
    size = voice_format.nominal_bytes if not voice_format.fixed_size else -(-voice_format.frame_bits // 8)
    at = now if timestamp is None else timestamp
    leg.send_voice(VoicePacket(at, voice_format, (bytes(size),) * voice_format.frames), now)


def test_motion_waits_for_one_and_a_half_voice_packets_and_sixty_milliseconds() -> None:
    for expected, gap in (([], 0.1499), ([MotionPayload], 0.1501)):
        leg = talking()
        sent(leg, 0.0)
        leg.send_frame(frame(0.01), 0.02)
        assert [type(body) for body in sent(leg, gap) if not isinstance(body, StreamParameters)] == expected


def test_voice_and_motion_are_on_one_clock() -> None:
    leg = started(RateOptions(voice=VoiceMode.AUTOMATIC))
    leg.send_frame(frame(100.0), 0.0)
    leg.bodies_to_send(0.0)
    say(leg, 0.1, 100.5)
    payloads = [body for body in sent(leg, 0.1) if isinstance(body, VoicePayload)]
    assert [body.number * GRID_MS for body in payloads] == [500]


def test_a_voice_format_is_sent_until_its_datagram_is_acknowledged() -> None:
    leg = talking()
    counts = []
    for counter in range(3):
        bodies = leg.bodies_to_send(float(counter))
        counts.append(sum(isinstance(decode_body(outgoing.body), VoiceFormatMessage) for outgoing in bodies))
        for outgoing in bodies:
            leg.on_sent(counter, outgoing, float(counter))
        if counter == 1:
            leg.receive_body(feedback(1), 1.5)
        say(leg, counter + 1.0)
    assert counts == [1, 1, 0]


def test_the_budget_learns_the_size_of_each_voice_packet(monkeypatch: pytest.MonkeyPatch) -> None:
    leg, sizes = started(RateOptions(voice=VoiceMode.AUTOMATIC)), []
    monkeypatch.setattr(leg.budget, "on_voice", lambda voice_format, size: sizes.append((voice_format.codec, size)))
    say(leg, 0.0)
    assert sizes == [("opus", 68)]
    assert leg.voice.has_packet
    leg.bodies_to_send(0.0)
    say(leg, 2 * OPEN_AFTER_S)
    assert not leg.voice.has_packet and len(sizes) == 1, "nothing is sent without reports"


@pytest.mark.parametrize(
    ("room", "fitting", "left"), [(62, 2, 0), (61, 1, 30), (31, 1, 0), (30, 0, 30), (100, 2, 38), (-5, 0, -5)]
)
def test_motion_goes_with_voice_as_far_as_there_is_room(
    monkeypatch: pytest.MonkeyPatch, room: int, fitting: int, left: int
) -> None:
    leg = talking(portrait=portrait())
    calls: list[object] = []
    monkeypatch.setattr(leg.budget, "room_beside_voice", lambda *args: (calls.append(args), room)[1])  # type: ignore[func-returns-value]
    monkeypatch.setattr(leg.motion, "flush", calls.append)
    monkeypatch.setattr(leg.budget, "allows_chunk", lambda _, room: calls.append(room))
    leg.motion._queue[:] = [OutgoingBody(encode_body(MotionPayload(0, bytes(29))), (n,)) for n in range(2)]
    waiting = sum(len(outgoing.body) + 1 for outgoing in leg.motion.waiting)
    bodies = leg.bodies_to_send(0.5, reserved=7)
    motion = [outgoing for outgoing in bodies if isinstance(decode_body(outgoing.body), MotionPayload)]
    voice = [outgoing for outgoing in bodies if outgoing not in motion]
    assert len(motion) == fitting and bodies == motion + voice
    voice_bytes = send_leg.VOICE_HEADERS + sum(len(outgoing.body) + 1 for outgoing in voice) + 7
    assert calls == [(voice_bytes, 0.5), room - waiting - 1, left]


def test_the_room_beside_voice_shrinks_with_what_waits() -> None:
    leg = talking(16.0)
    one = leg.room(0.0)
    say(leg, 0.06)
    assert one - leg.room(0.0) == leg.voice.waiting_bytes / 2 > 68
    leg.bodies_to_send(0.0)
    assert leg.room(0.0) == float("inf")


def test_the_end_of_talk_is_sent_at_once_and_another_state_rides_or_waits_a_tenth_of_a_second() -> None:
    leg = talking()
    sent(leg, 0.0)
    leg.set_voice_state(VoiceState.SILENT, 1.0, noise_level=60)
    assert sent(leg, 1.0) == [VoiceStateMessage(VoiceState.SILENT, 60)]
    assert sent(leg, 1.99) == [] and sent(leg, 2.0) == [VoiceStateMessage(VoiceState.SILENT, 60)]
    leg.set_voice_state(VoiceState.SILENT, 2.1, noise_level=40)
    assert sent(leg, 2.19) == [] and sent(leg, 2.2) == [VoiceStateMessage(VoiceState.SILENT, 40)]
    leg.set_voice_state(VoiceState.OFF, 3.0)
    leg.send_frame(frame(3.0), 3.0)
    assert VoiceStateMessage(VoiceState.OFF, 127) in sent(leg, 3.0)


def test_with_the_camera_off_what_waits_is_dropped_and_nothing_of_the_face_follows() -> None:
    leg = started(portrait=portrait())
    leg.send_frame(frame(0.0), 0.0)
    leg.send_camera_off(0.0)
    (announcement,) = leg.bodies_to_send(0.1)
    assert decode_body(announcement.body) == ParticipantMessage("", CameraState.OFF)
    leg.on_sent(0, announcement, 0.1)
    leg.receive_body(feedback(0), 0.2)
    leg.send_camera_off(0.9)
    assert sent(leg, 0.9) == [RoundTripMessage(100)]
    probes = [body for now in (12.0, 13.0) for body in sent(leg, now)]
    assert probes == [ParticipantMessage("", CameraState.OFF)] * 2, (
        "the probe of a broken link is none of the face either"
    )
    leg.receive_body(feedback(0), 20.0)
    leg.send_no_face(20.0, 20.0)
    kinds = {type(body) for body in sent(leg, 20.1)}
    assert kinds == {StreamParameters, KeepAlive, ParticipantMessage, PortraitChunk}


@pytest.mark.parametrize("kbps", [2.4, 4.8, 6.0])
def test_a_name_goes_with_the_voice_within_the_limit(kbps: float) -> None:
    leg, times, lost, now = Leg(rate=RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), name="N" * 32), [], 0, 0.0
    leg.start(0.0)
    while now < 9.0:
        voice_format = leg.voice_format
        assert voice_format
        say(leg, now + voice_format.packet_s, now)
        now += voice_format.packet_s
        leg.send_frame(frame(now - 0.05), now)
        datagrams = [split_bodies(outgoing.body) for outgoing in leg.call.bodies_to_send(now)]
        kinds = [part[0] for parts in datagrams for part in parts]
        lost += not any(kind & 0xC0 == VOICE_BIT for kind in kinds)
        times += [now] if PARTICIPANT in kinds else []
    assert lost == 0
    assert times[0] < 1.0 and len(times) >= 5, "nothing is acknowledged"


def test_reports_are_rarer_and_wait_longer_in_long_voice_packets() -> None:
    leg = started(RateOptions(kbps=2.4, voice=VoiceMode.AUTOMATIC))
    assert leg.voice_format
    packet_s = leg.voice_format.packet_s
    assert packet_s > 0.2
    assert leg.report_interval_s(0.0) == 0.5 and leg.ride_wait(0.0) == 0.0
    say(leg, 0.0)
    leg.bodies_to_send(0.0)
    assert leg.report_interval_s(0.1) == 4 * packet_s
    assert leg.ride_wait(0.1) == pytest.approx(1.5 * packet_s + 0.06 - 0.1)
    assert leg.ride_wait(1.5 * packet_s) == send_leg.RIDE_WAIT_S
    assert leg.report_interval_s(1.5 * packet_s + 0.07) == 0.5
    short = talking()
    assert (short.report_interval_s(0.1), short.ride_wait(0.1)) == (0.5, send_leg.RIDE_WAIT_S)


@pytest.mark.parametrize(("profile", "interval_s"), [("live", 1 / 15), ("narrow", 0.2)])
def test_a_report_waits_for_motion_until_even_a_still_face_would_have_sent_some(
    profile: str, interval_s: float
) -> None:
    leg = started(RateOptions(profile))
    assert leg.ride_wait(1.0) == 0.0
    for number in range(3):
        leg.send_frame(frame(1.0 + number / 15), 1.0)
    assert sent(leg, 1.0)
    wait_s = pytest.approx(max(send_leg.RIDE_WAIT_S, 1.25 * interval_s))
    assert leg.ride_wait(1.0 + send_leg.ACTIVE_S - 0.001) == wait_s
    assert leg.ride_wait(1.0 + send_leg.ACTIVE_S + 0.001) == 0.0


def test_a_probe_tells_the_time_also_without_a_face() -> None:
    leg = started()
    leg.send_no_face(7.0, 0.0)
    sent(leg, 0.0)
    leg.send_no_face(17.5, OPEN_AFTER_S)
    assert sent(leg, OPEN_AFTER_S) == [KeepAlive(10.5, Presence.FACE)]
