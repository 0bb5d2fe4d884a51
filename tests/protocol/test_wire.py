"""Message bodies: each decodes to what was encoded, limits are exact, and any bytes give a body or ProtocolError."""

from dataclasses import replace

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    FurrowMessage,
    KeepAlive,
    MotionPayload,
    ParticipantMessage,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    SingleBody,
    StreamParameters,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.participant.state import MAX_HEAD, CameraState
from conf.protocol.session.paths.candidates import PathCandidates
from conf.protocol.voice.formats import VoiceFormat, VoiceState
from conf.protocol.wire import MAX_BODY, decode_body, encode_body, join_bodies

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1), clock=12.345)
REPORT = Report(highest=100, missing=5, lost=7, jitter_ms=12, ack_delay_ms=30)
OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)
CODEC2 = VoiceFormat("codec2", 1600, 40, 5, fixed_size=True, repeated=2)
SLOWEST = VoiceFormat("x" * 16, 1, 1000, 1, fixed_size=True)
FIXED: dict[bytes, SingleBody] = {
    bytes((0, *msgpack.packb([12345, 320, 240, 1500, 50, 6400, 4200, 2000, 5100, 1100]))): PARAMETERS,
    bytes((1, *msgpack.packb([3250, 1]))): KeepAlive(3.25, Presence.NO_FACE),
    bytes((1, *msgpack.packb([0, 0]))): KeepAlive(0.0, Presence.FACE),
    bytes((10, 100, 5, 7, 12, 30)): Feedback(REPORT, refresh=True),
    bytes((2, 100, 5, 7, 12, 30)): Feedback(REPORT, refresh=False),
    bytes((3, *msgpack.packb([80]))): RoundTripMessage(80),
    b"\4": Bye(),
    bytes((8, *msgpack.packb([3, "opus", 9000, 60, 1, 0]))): VoiceFormatMessage(3, OPUS),
    bytes((8, *msgpack.packb([15, "codec2", 1600, 40, 5, 5]))): VoiceFormatMessage(15, CODEC2),
    bytes((8, *msgpack.packb([0, "x" * 16, 1, 1000, 1, 1]))): VoiceFormatMessage(0, SLOWEST),
    b"\x09\0\x7f": VoiceStateMessage(VoiceState.OFF, 127),
    b"\x09\1\0": VoiceStateMessage(VoiceState.SILENT, 0),
    b"\x09\3\x7f": VoiceStateMessage(VoiceState.MUTED, 127),
    b"\x09\4\x7f": VoiceStateMessage(VoiceState.NO_ROOM, 127),
    b"\x0f\0": FurrowMessage(0),
    b"\x0f\7": FurrowMessage(7),
}
VARIABLE: dict[bytes, Body] = {
    b"\xcd\1\2\3": MotionPayload(77, b"\1\2\3"),
    b"\x80": MotionPayload(0, b""),
    b"\5chunk": PortraitChunk(b"chunk"),
    b"\6ack": PortraitAck(b"ack"),
    b"\x40\xf3data": VoicePayload(7, True, 3, b"data"),
    b"\x0e\x81\0\0": PathCandidates(1, 0, True, ()),
    b"\x0e\x7f\x03\x10\xc6\x33\x64\x07\x9c\x40": PathCandidates(127, 3, False, (("198.51.100.7", 40000),)),
    b"\x7f\xe0d": VoicePayload(511, False, 0, b"d"),
    b"\x16\x83motion\5chunk": Composite((MotionPayload(3, b"motion"), PortraitChunk(b"chunk"))),
    b"\x10\4\x11\x80m\x40\0v": Composite((Bye(), MotionPayload(0, b"m"), VoicePayload(0, False, 0, b"v"))),
    b"\x3f\x80" + bytes(47) + b"\4": Composite((MotionPayload(0, bytes(47)), Bye())),
    b"\7\x31\x80" + bytes(48) + b"\4": Composite((MotionPayload(0, bytes(48)), Bye())),
    b"\7\xff\x80" + bytes(254) + b"\4": Composite((MotionPayload(0, bytes(254)), Bye())),
}


@pytest.mark.parametrize(("data", "body"), [*FIXED.items(), *VARIABLE.items()], ids=lambda value: str(value)[:20])
def test_bodies_have_the_bytes_of_wire_md(data: bytes, body: Body) -> None:
    assert encode_body(body) == data
    assert decode_body(data) == body


@pytest.mark.parametrize("data", FIXED)
def test_every_truncation_and_every_extra_byte_is_rejected(data: bytes) -> None:
    for length in range(len(data)):
        with pytest.raises(ProtocolError):
            decode_body(data[:length])
    with pytest.raises(ProtocolError):
        decode_body(data + b"\0")


@pytest.mark.parametrize("sizes", [[1], [1] * 9, [256, 1]])
def test_a_composite_of_one_body_of_nine_or_of_a_long_one_is_refused(sizes: list[int]) -> None:
    with pytest.raises(ValueError, match="a composite has 2 to 8 bodies of up to 255 bytes before the last"):
        join_bodies([bytes((0x80,)) * size for size in sizes])


@pytest.mark.slow
@given(st.lists(st.sampled_from([*FIXED.values(), MotionPayload(5, bytes(300))]), min_size=2, max_size=8))
def test_a_composite_gives_back_its_bodies(bodies: list[SingleBody]) -> None:
    bodies.sort(key=lambda body: len(encode_body(body)))
    composite = Composite(tuple(bodies))
    if sum(isinstance(body, MotionPayload) for body in bodies) < 2:
        assert decode_body(encode_body(composite)) == composite
        overhead = len(encode_body(composite)) - sum(len(encode_body(body)) for body in bodies)
        assert overhead == len(bodies) - 1


def test_only_the_low_seven_bits_of_the_frame_number_are_sent() -> None:
    assert encode_body(MotionPayload(128 * 9 + 5, b"")) == b"\x85"


def test_a_long_round_trip_is_sent_as_the_maximum() -> None:
    assert decode_body(encode_body(RoundTripMessage(99_999))) == RoundTripMessage(65_535)
    assert decode_body(encode_body(RoundTripMessage(65_534))) == RoundTripMessage(65_534)


@pytest.mark.parametrize("size", [1, MAX_BODY])
def test_a_body_of_1_to_1100_bytes_is_accepted(size: int) -> None:
    assert MAX_BODY == 1100
    assert decode_body(b"\x80" * size) == MotionPayload(0, b"\x80" * (size - 1))


@pytest.mark.parametrize(
    "body",
    [
        *(replace(PARAMETERS, width=value) for value in (1, 16384)),
        *(replace(PARAMETERS, height=value) for value in (1, 16384)),
        *(replace(PARAMETERS, fps=value) for value in (0.01, 240.0)),
        *(replace(PARAMETERS, points=value) for value in (1, 64)),
        *(replace(PARAMETERS, fapu=(1.0, 1.0, 1.0, 1.0, value)) for value in (0.001, 65.535)),
        replace(PARAMETERS, clock=0.0),
        replace(PARAMETERS, clock=((1 << 48) - 1) / 1000),
    ],
    ids=str,
)
def test_values_at_the_limits_are_accepted(body: Body) -> None:
    assert decode_body(encode_body(body)) == body


def parameters(**changes: object) -> bytes:
    """Return the body of stream parameters, some integers replaced."""
    names = ("clock", "width", "height", "rate", "points", *"abcde")
    values = dict(zip(names, [12345, 320, 240, 1500, 50, 6400, 4200, 2000, 5100, 1100], strict=True)) | changes
    return b"\0" + msgpack.packb(list(values.values()))


def voice_format(**changes: object) -> bytes:
    """Return the body of a voice format, some fields replaced."""
    names = ("number", "codec", "rate", "ms", "frames", "flags")
    values = dict(zip(names, [3, "opus", 9000, 60, 1, 0], strict=True)) | changes
    return b"\x08" + msgpack.packb(list(values.values()))


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (b"", "a body is empty or too long"),
        (b"\x80" * 1101, "a body is empty or too long"),
        (b"\x0f\x91\0", "not one byte of furrows"),
        (b"\x0f", "not one byte of furrows"),
        *((parameters(**{name: 0}), "out of range") for name in ("width", "height", "rate", "points", "a", "e")),
        *((parameters(**{name: 16385}), "out of range") for name in ("width", "height")),
        (parameters(rate=24001), "out of range"),
        (parameters(points=65), "out of range"),
        (parameters(c=65536), "a FAPU distance out of range"),
        (parameters(clock=1 << 48), "not a small integer"),
        (parameters(clock=-1), "not a small integer"),
        (parameters(clock=True), "not a small integer"),
        (parameters(clock=1.0), "not a small integer"),
        (parameters(extra=1), "not msgpack"),
        (b"\0" + msgpack.packb([1] * 9), "not an array of 10"),
        (b"\0" + msgpack.packb(7), "not an array of 10"),
        *((b"\3" + msgpack.packb([value]), "not msgpack") for value in ("a", b"a", {1: 1}, msgpack.ExtType(1, b"a"))),
        (b"\1" + msgpack.packb([0, 2]), "unknown presence"),
        (b"\2", "not five msgpack integers"),
        (b"\x0a\1", "not five msgpack integers"),
        (b"\3" + msgpack.packb([65536]), "more than a minute"),
        (b"\4\0", "bytes after a bye"),
        (b"\7", "an empty body"),
        (b"\7\0\4", "an empty body"),
        (b"\7\1\4", "a composite cut off"),
        (b"\7\2\4", "a composite cut off"),
        (b"\x10", "a composite cut off"),
        (b"\x10\4", "a composite cut off"),
        (b"\x10\4\x10\4", "a composite cut off"),
        (b"\x10\4" * 8 + b"\4", "too many"),
        (b"\x12\x10\4\4\4", "unknown kind 16"),
        (b"\x10\x0f\4", "not one byte of furrows"),
        (b"\x40\0", "voice without data"),
        (b"\x0e\x81\0", "path candidates cut off"),
        (b"\x0e\x80\0\0", "revision out of range"),
        (b"\x0e\x01\x80\0", "revision out of range"),
        (b"\x0e\x01\0\x10" + bytes(5), "of a wrong length"),
        (b"\x0e\x01\0\x10" + bytes(7), "of a wrong length"),
        (b"\x0e\x01\0\x90" + bytes(54), "of a wrong length"),
        (b"\x0e\x01\0\x81" + bytes(66), "of a wrong length"),
        (b"\x7f", "voice without data"),
        (b"\x08\xc1", "not msgpack"),
        (voice_format(extra=1), "not msgpack"),
        (b"\x08" + msgpack.packb([0, "opus", 9000, 60, 1]), "fields of other types"),
        *((voice_format(**{name: True}), "fields of other types") for name in ("number", "frames", "flags")),
        (voice_format(codec=1), "fields of other types"),
        (voice_format(codec="x" * 17), "not msgpack"),
        *((voice_format(codec=name), "1 to 16 ASCII") for name in ("", "é", "a\n")),
        (voice_format(number=16), "out of range"),
        (voice_format(number=-1), "out of range"),
        (voice_format(flags=-1), "out of range"),
        (voice_format(flags=12), "repeats more than the one before"),
        *((voice_format(**{name: 0}), "out of range") for name in ("rate", "ms", "frames")),
        (voice_format(rate=510_001), "out of range"),
        (voice_format(rate=16), "out of range"),
        (voice_format(ms=20, frames=51), "duration"),
        (voice_format(ms=10), "duration"),
        (b"\x09\0", "not a voice state"),
        (b"\x09\2\0", "not a voice state"),
        (b"\x09\0\x80", "not a voice state"),
        (b"\x09\0\0\0", "not a voice state"),
        (b"\x0b", "not a camera state and a name"),
        (b"\x0b\0" + b"x" * 33, "not a camera state and a name"),
        (b"\x0b\0\xff", "a name is not UTF-8"),
        (b"\x0c" + bytes(7), "a token has 8 bytes"),
        (b"\x0d" + bytes(9), "a token has 8 bytes"),
    ],
)
def test_invalid_bodies_are_rejected(data: bytes, error: str) -> None:
    with pytest.raises(ProtocolError, match=error):
        decode_body(data)


@given(st.binary(max_size=MAX_BODY + 10))
def test_any_bytes_give_a_body_or_protocol_error(data: bytes) -> None:
    try:
        decode_body(data)
    except ProtocolError:
        pass


VALUES = (
    st.integers(-(2**63), 2**64 - 1)
    | st.binary(max_size=32)
    | st.none()
    | st.floats()
    | st.lists(st.integers(0, 1 << 40))
)


@pytest.mark.slow
@given(st.integers(0, 127), st.lists(VALUES, max_size=12))
def test_any_msgpack_array_gives_a_body_or_protocol_error(kind: int, values: list[object]) -> None:
    try:
        decode_body(bytes((kind,)) + msgpack.packb(values))
    except ProtocolError:
        pass


def test_the_upper_bits_of_furrows_are_left_to_later_versions() -> None:
    for high in range(32):
        assert decode_body(bytes((0x0F, high << 3 | 5))) == FurrowMessage(5)


@pytest.mark.parametrize("camera", [CameraState.ON, CameraState.OFF])
def test_a_head_shares_the_byte_of_camera_and_portrait(camera: CameraState) -> None:
    for head in range(MAX_HEAD + 1):
        message = ParticipantMessage("Ada", camera, head % 2 == 1, head)
        assert len(encode_body(message)) == 5 and decode_body(encode_body(message)) == message


def test_a_received_name_is_cleaned() -> None:
    assert decode_body(b"\x0b\0 \x1b[2JAda\n") == ParticipantMessage("[2JAda", CameraState.ON)
