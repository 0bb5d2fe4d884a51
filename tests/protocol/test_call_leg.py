"""Two ways over one session: bodies go to the half they concern, reports ride, voice and motion share a limit."""

import copy

import pytest

from conf.protocol.call_leg import QUIET_DATAGRAMS, CallLeg
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    KeepAlive,
    MotionPayload,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    SingleBody,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.portrait.chunks import Ack, Chunk, encode_ack, encode_chunk
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import RIDE_WAIT_S, SendLeg
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.wire import decode_body, encode_body
from tests.protocol.motion.test_inbound import payload
from tests.protocol.motion.test_outbound import PARAMETERS, frame
from tests.support.two_way_call import TwoWayCall

OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)


def both(rate: RateOptions | None = None) -> CallLeg:
    leg = CallLeg(send=SendLeg(PARAMETERS, 0.0, rate=rate), receive=ReceiveLeg())
    assert leg.send
    leg.send.start(0.0)
    return leg


def halves(leg: CallLeg) -> tuple[SendLeg, ReceiveLeg]:
    assert leg.send and leg.receive
    return leg.send, leg.receive


def deliver(leg: CallLeg, *bodies: Body, now: float = 0.0, counter: int = 0) -> int | None:
    acknowledged = None
    for number, body in enumerate(bodies):
        acknowledged = leg.receive_body(encode_body(body), counter + number, 60, now)
    return acknowledged


def sent(leg: CallLeg, now: float) -> list[list[SingleBody]]:
    """Return the bodies of each datagram."""
    bodies = [decode_body(outgoing.body) for outgoing in leg.bodies_to_send(now)]
    return [list(body.bodies) if isinstance(body, Composite) else [body] for body in bodies]


def types(leg: CallLeg, now: float) -> list[list[type]]:
    return [[type(body) for body in datagram] for datagram in sent(leg, now)]


def test_each_body_goes_to_the_half_that_it_concerns() -> None:
    leg = both()
    send, receive = halves(leg)
    report = Feedback(Report(0, 0, 0, 7, 0), refresh=False)
    composite = Composite((report, VoiceFormatMessage(0, OPUS), payload(0), VoicePayload(0, True, 0, b"voice")))
    assert deliver(leg, composite) == 0
    assert send.status(0.0).jitter_ms == 7.0
    assert receive.motion.frames.count == 1 and receive.voice.format == OPUS
    assert receive.traffic.count == 1 and receive.rejected == 0 and not leg.ended
    deliver(leg, Bye(), counter=1)
    assert leg.ended


@pytest.mark.parametrize("leg", [CallLeg(), CallLeg(receive=ReceiveLeg()), CallLeg(send=SendLeg(PARAMETERS, 0.0))])
def test_a_half_that_is_absent_ignores_what_is_for_it(leg: CallLeg) -> None:
    report = Feedback(Report(0, 0, 0, 0, 0), refresh=True)
    ack, chunk = PortraitAck(encode_ack(Ack(1, (), ()))), PortraitChunk(encode_chunk(Chunk(3, 80, 0, 100, bytes(80))))
    others: list[SingleBody] = [KeepAlive(0.0, Presence.FACE), PARAMETERS, RoundTripMessage(80), payload(0)]
    voice: list[SingleBody] = [VoiceFormatMessage(0, OPUS), VoicePayload(0, True, 0, b"voice")]
    state = VoiceStateMessage(VoiceState.OFF, 127)
    assert deliver(leg, ack, chunk, *others, *voice, state, report) == 0
    assert leg.receive is None or leg.receive.rejected == 0


def test_of_a_composite_one_body_may_fail_alone_and_then_it_is_not_acknowledged() -> None:
    leg = both()
    _, receive = halves(leg)
    deliver(leg, Composite((VoiceFormatMessage(0, OPUS), VoiceStateMessage(VoiceState.SILENT, 60))))
    report = Feedback(Report(0, 0, 0, 0, 0), refresh=False)
    assert (
        deliver(leg, Composite((report, MotionPayload(5, b"\xd8\0"), VoicePayload(0, True, 0, b"a"))), counter=1) == 0
    )
    assert receive.rejected == 1 and receive.voice.state is VoiceState.TALKING
    ((feedback,),) = sent(leg, 1.0)
    assert isinstance(feedback, Feedback) and feedback.report.highest == 0
    assert receive.traffic.count == 2


def test_a_malformed_body_changes_nothing() -> None:
    leg = both()
    assert leg.receive_body(b"\x12\x10\4\4\4", 0, 50, 0.0) is None
    assert halves(leg)[1].rejected == 1 and not leg.ended
    assert sent(leg, 1.0) == [], "nothing could be acknowledged"


def test_a_report_rides_with_the_next_motion() -> None:
    leg = both()
    send, _ = halves(leg)
    send.send_frame(frame(0.0), 0.0)
    leg.bodies_to_send(0.0)
    deliver(leg, RoundTripMessage(80), now=0.01)
    assert sent(leg, 0.02) == [], "the next frame is soon due"
    send.send_frame(frame(0.1), 0.1)
    assert types(leg, 0.1) == [[Feedback, MotionPayload]]
    deliver(leg, RoundTripMessage(80), now=0.11, counter=1)
    send.send_frame(frame(0.2), 0.2)
    assert types(leg, 0.2) == [[MotionPayload]], "the next report is due half a second after the last"


def test_a_report_without_a_datagram_to_ride_in_is_sent_alone_after_a_wait() -> None:
    leg = both()
    send, _ = halves(leg)
    send.send_frame(frame(0.0), 0.0)
    leg.bodies_to_send(0.0)
    deliver(leg, RoundTripMessage(80), now=0.01)
    assert sent(leg, 0.01) == [] == sent(leg, 0.01 + RIDE_WAIT_S - 0.001)
    assert types(leg, 0.01 + RIDE_WAIT_S) == [[Feedback]]
    deliver(leg, RoundTripMessage(80), now=5.0, counter=1)
    assert types(leg, 5.0) == [[Feedback]], "nothing was sent lately"


def test_without_a_sending_half_reports_do_not_wait() -> None:
    leg = CallLeg(receive=ReceiveLeg())
    deliver(leg, RoundTripMessage(80), now=0.01)
    assert types(leg, 0.01) == [[Feedback]]
    deliver(leg, RoundTripMessage(80), now=0.02, counter=1)
    assert types(leg, 0.5) == [] and types(leg, 0.51) == [[Feedback]]


def test_a_report_and_a_portrait_ack_share_a_datagram() -> None:
    leg = CallLeg(receive=ReceiveLeg())
    deliver(leg, PortraitChunk(encode_chunk(Chunk(3, 80, 0, 20, bytes(20)))), now=0.01)
    assert types(leg, 0.01) == [[Feedback, PortraitAck]]
    assert types(leg, 1.0) == []


@pytest.mark.slow
def test_acknowledgements_call_for_no_report_but_one_now_and_then() -> None:
    leg = both()
    send, _ = halves(leg)
    report = Feedback(Report(0, 0, 0, 0, 0), refresh=False)
    riding = []
    for counter in range(3 * QUIET_DATAGRAMS):
        now = counter / 2
        deliver(
            leg,
            report if counter % 2 else Composite((report, PortraitAck(encode_ack(Ack(1, (), ()))))),
            now=now,
            counter=counter,
        )
        send.send_frame(frame(now), now)
        for datagram in types(leg, now):
            assert datagram != [Feedback]
            riding += [counter] if Feedback in datagram else []
    assert riding == [QUIET_DATAGRAMS - 1, 2 * QUIET_DATAGRAMS - 1, 3 * QUIET_DATAGRAMS - 1]


def test_two_ends_with_nothing_to_say_fall_silent() -> None:
    call = TwoWayCall(RateOptions(), motions=(None, None))
    call.a.send.send_no_face(0.0, 0.0)
    call.run(9)
    assert len(call.a.wire) <= 3 and len(call.b.wire) <= 2, "a report that answers a report would be answered for ever"


def test_the_end_of_a_call_is_said_twice_within_the_limit() -> None:
    leg = both()
    assert [decode_body(outgoing.body) for outgoing in leg.closing_bodies(0.0)] == [Bye(), Bye()]
    assert CallLeg(receive=ReceiveLeg()).closing_bodies(0.0) == []
    assert both(RateOptions(kbps=0.03)).closing_bodies(0.0) == []


def test_motion_waits_for_the_voice_packet_of_its_time() -> None:
    leg = both(RateOptions(voice=VoiceMode.AUTOMATIC))
    send, _ = halves(leg)
    assert send.voice_format == OPUS
    send.send_voice(VoicePacket(0.0, OPUS, (b"a",)), 0.06)
    leg.bodies_to_send(0.06)
    send.send_frame(frame(0.07), 0.08)
    assert types(leg, 0.08) == []
    send.send_voice(VoicePacket(0.06, OPUS, (b"b",)), 0.12)
    (bodies,) = sent(leg, 0.12)
    assert [type(body) for body in bodies[-2:]] == [MotionPayload, VoicePayload]


def test_motion_waits_no_longer_when_the_voice_stops() -> None:
    leg = both(RateOptions(voice=VoiceMode.AUTOMATIC))
    send, _ = halves(leg)
    for stop in ("state", "nothing"):
        begin = 0.0 if stop == "state" else 5.0
        send.send_voice(VoicePacket(begin, OPUS, (b"a",)), begin + 0.06)
        leg.bodies_to_send(begin + 0.06)
        send.send_frame(frame(begin + 0.07), begin + 0.08)
        if stop == "state":
            send.set_voice_state(VoiceState.SILENT, begin + 0.09, noise_level=60)
            assert [d[-2:] for d in types(leg, begin + 0.09)] == [[VoiceStateMessage, MotionPayload]]
        else:
            assert types(leg, begin + 0.2) == []
            assert [d[-1:] for d in types(leg, begin + 0.22)] == [[MotionPayload]]


def test_no_voice_without_a_session_or_where_it_does_not_fit() -> None:
    leg = SendLeg(PARAMETERS, 0.0, rate=RateOptions(voice=VoiceMode.AUTOMATIC))
    assert leg.voice_format is None
    leg.send_voice(VoicePacket(0.0, OPUS, (b"a",)), 0.1)
    assert leg.bodies_to_send(0.1) == []
    for kbps, codec in ((2.3, None), (2.4, "codec2"), (100.0, "opus")):
        send, _ = halves(both(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC)))
        assert (send.voice_format.codec if send.voice_format else None) == codec
    assert halves(both())[0].voice_format is None


def test_acknowledgements_and_counters_go_to_the_sending_half(monkeypatch: pytest.MonkeyPatch) -> None:
    leg, calls = both(), list[object]()
    send, receive = halves(leg)
    monkeypatch.setattr(send, "receive_portrait_ack", calls.append)
    monkeypatch.setattr(send, "on_sent", lambda *args: calls.append(args))
    ack = PortraitAck(encode_ack(Ack(1, (), ())))
    deliver(leg, ack, Composite((ack, RoundTripMessage(80))))
    send.send_frame(frame(0.0), 0.5)
    (outgoing,) = leg.bodies_to_send(0.5)
    leg.on_sent(7, outgoing, 0.6)
    assert calls == [ack, ack, (7, outgoing, 0.6)]
    for _ in range(2):
        leg.receive_body(b"\x02junk", 3, 60, 0.7)
    assert receive.rejected == 2


def test_the_arrival_of_content_gives_the_jitter_of_the_report() -> None:
    leg = both()
    deliver(leg, payload(15), now=10.0)
    deliver(leg, Composite((payload(30), RoundTripMessage(80))), now=11.16, counter=1)
    (datagram,) = sent(leg, 12.0)
    assert isinstance(datagram[0], Feedback) and not datagram[0].refresh
    assert datagram[0].report.jitter_ms == 10  # 160 ms / 16


@pytest.mark.parametrize(("spare", "reserves"), [(0, True), (-1, False)])
def test_acknowledgements_go_with_voice_only_as_far_as_there_is_room(
    monkeypatch: pytest.MonkeyPatch, spare: int, reserves: bool
) -> None:
    leg = both()
    deliver(leg, PortraitChunk(encode_chunk(Chunk(3, 80, 0, 20, bytes(20)))), RoundTripMessage(80))
    ((report, ack),) = sent(copy.deepcopy(leg), 1.0)
    needed = len(encode_body(report)) + 1 + len(encode_body(ack)) + 1
    reserved: list[int] = []
    monkeypatch.setattr(leg.send, "room", lambda now: needed + spare * now)
    monkeypatch.setattr(leg.send, "bodies_to_send", lambda _, *, reserved: given(reserved))

    def given(size: int) -> list[OutgoingBody]:
        reserved.append(size)
        return []

    leg.bodies_to_send(1.0)
    assert reserved == [needed if reserves else 0]


def test_only_a_datagram_with_voice_may_use_the_limit_completely() -> None:
    leg = both(RateOptions(kbps=16.0, voice=VoiceMode.AUTOMATIC))
    send, _ = halves(leg)
    assert send.budget.consume(1250, 0.0)
    send.send_frame(frame(0.0), 0.0)
    assert sent(leg, 0.0) == []
    send.send_voice(VoicePacket(0.0, OPUS, (bytes(68),)), 0.0)
    ((*_, last),) = types(leg, 0.0)
    assert last is VoicePayload
    assert leg.closing_bodies(0.0) == []
