"""The sending half without a session: bodies out, reports in."""

import pytest

from conf.protocol import send_leg
from conf.protocol.messages import (
    Bye,
    Composite,
    KeepAlive,
    MotionPayload,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    StreamParameters,
)
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.portrait.chunks import Ack, encode_ack
from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.wire import decode_body, encode_body
from tests.protocol.motion.test_outbound import frame
from tests.support.send_legs import Leg, acknowledge_all, feedback, portrait, sent, started


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
