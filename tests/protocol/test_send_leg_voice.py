"""The sending half with voice: one clock, one limit, reports that ride."""

import pytest

from conf.protocol import send_leg
from conf.protocol.messages import (
    KeepAlive,
    MotionPayload,
    ParticipantMessage,
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
from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.voice.formats import GRID_MS, VoiceState
from conf.protocol.wire import PARTICIPANT, VOICE_BIT, decode_body, encode_body, split_bodies
from tests.protocol.motion.test_outbound import frame
from tests.support.send_legs import Leg, feedback, portrait, say, sent, started, talking


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
    assert times[0] < 1.0 and len(times) >= 4, "nothing is acknowledged"


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
