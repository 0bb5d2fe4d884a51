import pytest

from conf.protocol.messages import Composite, FurrowMessage, StreamParameters, VoiceFormatMessage, VoiceStateMessage
from conf.protocol.outgoing import OutgoingBody, group_bodies, join_outgoing
from conf.protocol.voice.formats import VoiceFormat, VoiceState
from conf.protocol.wire import MAX_BODY, MOTION_BIT, VOICE_BIT, decode_body

REPORT, PORTRAIT_ACK, BYE = b"\2\0\x95\1\0\0\0\0", b"\6ack", b"\4"
PARAMETERS, CHUNK, VOICE, MOTION = b"\0\x9aparameters", b"\5chunk", b"\x41\0voice", b"\x85motion"


@pytest.mark.parametrize(
    ("body", "kind"),
    [(MOTION, MOTION_BIT), (b"\xff", MOTION_BIT), (VOICE, VOICE_BIT), (b"\x7f\0a", VOICE_BIT), (BYE, 4)],
)
def test_the_kind_of_motion_and_voice_is_their_bit(body: bytes, kind: int) -> None:
    assert OutgoingBody(body).kind == kind


def test_bodies_are_ordered_and_share_a_datagram() -> None:
    ordered = [
        REPORT,
        PORTRAIT_ACK,
        PARAMETERS,
        b"\3\x91\1",
        b"\x08fmt",
        b"\x09\0\0",
        b"\1\x92\0\0",
        b"\x0f\2",
        MOTION,
        VOICE,
        CHUNK,
    ]
    (first, second) = group_bodies([OutgoingBody(body) for body in reversed(ordered)])
    assert [part.body for part in first + second] == ordered
    assert (len(first), len(second)) == (8, 3), "a composite holds eight bodies"


@pytest.mark.parametrize(("motion_bytes", "datagrams"), [(255, 1), (256, 2)])
def test_only_the_last_body_of_a_datagram_may_be_long(motion_bytes: int, datagrams: int) -> None:
    bodies = [OutgoingBody(b"\x80" * motion_bytes), OutgoingBody(CHUNK)]
    assert len(group_bodies(bodies)) == datagrams
    assert len(group_bodies([OutgoingBody(b"\x80" * 200), OutgoingBody(b"\5" * (MAX_BODY - 202))])) == 1
    assert len(group_bodies([OutgoingBody(b"\x80" * 200), OutgoingBody(b"\5" * (MAX_BODY - 201))])) == 2


def test_joined_bodies_mean_what_each_meant() -> None:
    parameters = StreamParameters(1, 1, 1.0, 1, (1.0,) * 5)
    voice_format = VoiceFormatMessage(0, VoiceFormat("opus", 9000, 60, 1, fixed_size=False))
    state = VoiceStateMessage(VoiceState.SILENT, 60)
    parts = [
        OutgoingBody(BYE, parameters=parameters),
        OutgoingBody(BYE, voice_format=voice_format),
        OutgoingBody(BYE, voice_state=state),
        OutgoingBody(BYE, furrow=FurrowMessage(2)),
        OutgoingBody(MOTION, (3, 4)),
        OutgoingBody(MOTION, (6,)),
    ]
    joined = join_outgoing(parts)
    body = decode_body(joined.body)
    assert isinstance(body, Composite) and len(body.bodies) == 6
    assert joined == OutgoingBody(joined.body, (3, 4, 6), parameters, voice_format, state, furrow=FurrowMessage(2))
    assert join_outgoing(parts[:1]) is parts[0]
