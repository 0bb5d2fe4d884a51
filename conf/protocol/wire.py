"""Message bodies, the content of a sealed datagram, to bytes and back. WIRE.md describes each.

Strategy. The first byte is the kind. Motion is nearly all of the traffic, so its kind takes one byte together with the
low seven bits of the frame number. Every other body is a kind below 128 and, for most, one msgpack array of small
integers. A composite is a short body, whose length is the kind, and the rest of the bytes as another body, which may be
a composite again: so each body more costs one byte. `decode_body` returns a body or raises ProtocolError, whatever the
bytes: any other exception is a bug.
"""

from collections.abc import Callable, Sequence
from typing import Any

import msgpack

from conf.errors import ProtocolError
from conf.protocol.feedback import decode_report, encode_report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    FurrowMessage,
    KeepAlive,
    MotionPayload,
    ParticipantMessage,
    PathAnswer,
    PathProbe,
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
from conf.protocol.participant.state import MAX_NAME_BYTES, CameraState, clean_name
from conf.protocol.session.paths.candidates import PATH_CANDIDATES, PathCandidates, decode_candidates, encode_candidates
from conf.protocol.session.paths.validation import PATH_ANSWER, PATH_PROBE, TOKEN_BYTES
from conf.protocol.voice.formats import MAX_CODEC_NAME, MAX_FORMATS, MAX_NOISE_LEVEL, VoiceFormat, VoiceState

NUMBER_BITS = 7
MOTION_BIT = 1 << NUMBER_BITS
MAX_BODY = 1100
MAX_POINTS = 64
MILLISECONDS = 1000  # per second
FAPU_STEPS = 1000  # per centimetre
FPS_STEPS = 100
PARAMETERS, KEEP_ALIVE, REPORT, ROUND_TRIP, BYE, PORTRAIT_CHUNK, PORTRAIT_ACK, COMPOSITE = range(8)
CAMERA_BIT, WITHDRAWN_BIT, HEAD_SHIFT = 1, 2, 2  # in the first byte of a participant
VOICE_FORMAT, VOICE_STATE, REFRESH_REPORT, PARTICIPANT = range(8, 12)
FURROWS = 15
MAX_FURROW_LEVEL = 7  # the other bits of its byte are ignored
SHORT_COMPOSITE = 0x10  # kinds 10 to 3f: a composite whose first body has kind - 0f bytes
VOICE_BIT = 0x40  # kinds 40 to 7f
MAX_SHORT_FIRST = VOICE_BIT - SHORT_COMPOSITE
MAX_INNER_BODY = 255  # of each body in a composite but the last: its length is one byte
MAX_BODIES = 8  # in a composite
VOICE_NUMBER_BITS = 9
_VOICE_FIELDS = 2  # bytes before the data of a voice body


def encode_body(body: Body) -> bytes:
    """Return the bytes of a body. Raises ValueError if a composite cannot hold its bodies."""
    if isinstance(body, Composite):
        return join_bodies([encode_body(inner) for inner in body.bodies])
    if isinstance(body, MotionPayload):
        return bytes((MOTION_BIT | body.frame_number & (MOTION_BIT - 1),)) + body.payload
    if isinstance(body, VoicePayload):
        return _encode_voice(body)
    if isinstance(body, Feedback):
        return bytes((REFRESH_REPORT if body.refresh else REPORT,)) + encode_report(body.report)
    kind, encode = _ENCODERS[type(body)]
    return bytes((kind,)) + encode(body)


def decode_body(data: bytes) -> Body:
    """Return the body. Raises ProtocolError."""
    if not 0 < len(data) <= MAX_BODY:
        raise ProtocolError("a body is empty or too long")
    if data[0] == COMPOSITE or SHORT_COMPOSITE <= data[0] < VOICE_BIT:
        return Composite(tuple(_decode_single(part) for part in split_bodies(data)))
    return _decode_single(data)


def join_bodies(parts: Sequence[bytes]) -> bytes:
    """Return the bytes of a composite of encoded bodies. Raises ValueError if it cannot hold them."""
    if not 2 <= len(parts) <= MAX_BODIES or any(len(part) > MAX_INNER_BODY for part in parts[:-1]):
        raise ValueError(f"a composite has 2 to {MAX_BODIES} bodies of up to {MAX_INNER_BODY} bytes before the last")
    return b"".join(_composite_kind(len(part)) + part for part in parts[:-1]) + parts[-1]


def _composite_kind(size: int) -> bytes:
    return bytes((SHORT_COMPOSITE - 1 + size,)) if size <= MAX_SHORT_FIRST else bytes((COMPOSITE, size))


def split_bodies(data: bytes) -> list[bytes]:
    """Return the encoded bodies in a composite, or the only one. Raises ProtocolError if the composite is malformed."""
    parts: list[bytes] = []
    at = 0
    while at < len(data) and (data[at] == COMPOSITE or SHORT_COMPOSITE <= data[at] < VOICE_BIT):
        is_long = data[at] == COMPOSITE
        size = data[at + 1] if is_long and at + 1 < len(data) else data[at] - SHORT_COMPOSITE + 1
        begin = at + 1 + is_long
        at = begin + size
        parts.append(data[begin:at])
        if size < 1 or len(parts) == MAX_BODIES:
            raise ProtocolError("a composite with an empty body or too many")
    if at >= len(data):
        raise ProtocolError("a composite cut off")
    return [*parts, data[at:]]


def _decode_single(data: bytes) -> SingleBody:
    if data[0] & MOTION_BIT:
        return MotionPayload(data[0] & (MOTION_BIT - 1), data[1:])
    if data[0] & VOICE_BIT:
        return _decode_voice(data)
    decoder = _DECODERS.get(data[0])
    if decoder is None:
        raise ProtocolError(f"unknown kind {data[0]}")
    return decoder(data[1:])


def _unpack(data: bytes, count: int) -> list[int]:
    try:
        array = msgpack.unpackb(data, max_array_len=count, max_map_len=0, max_ext_len=0, max_str_len=0, max_bin_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("not msgpack") from error
    if type(array) is not list or len(array) != count:
        raise ProtocolError(f"not an array of {count}")
    if any(type(n) is not int or not 0 <= n < 1 << 48 for n in array):
        raise ProtocolError("a field is not a small integer")
    return array


def _encode_parameters(body: StreamParameters) -> bytes:
    fapu = (round(distance * FAPU_STEPS) for distance in body.fapu)
    clock, rate = round(body.clock * MILLISECONDS), round(body.fps * FPS_STEPS)
    return bytes(msgpack.packb([clock, body.width, body.height, rate, body.points, *fapu]))


def _decode_parameters(data: bytes) -> StreamParameters:
    clock, width, height, rate, points, *fapu = _unpack(data, 10)
    if not (0 < width <= 16384 and 0 < height <= 16384 and 0 < rate <= 240 * FPS_STEPS and 0 < points <= MAX_POINTS):
        raise ProtocolError("stream parameters out of range")
    if not all(0 < distance <= 0xFFFF for distance in fapu):
        raise ProtocolError("a FAPU distance out of range")
    distances = tuple(distance / FAPU_STEPS for distance in fapu)
    return StreamParameters(width, height, rate / FPS_STEPS, points, distances, clock / MILLISECONDS)


def _decode_keep_alive(data: bytes) -> KeepAlive:
    clock, presence = _unpack(data, 2)
    if presence not in _PRESENCES:
        raise ProtocolError("unknown presence")
    return KeepAlive(clock / MILLISECONDS, Presence(presence))


def _decode_round_trip(data: bytes) -> RoundTripMessage:
    (milliseconds,) = _unpack(data, 1)
    if milliseconds > 0xFFFF:
        raise ProtocolError("a round trip of more than a minute")
    return RoundTripMessage(milliseconds)


def _decode_bye(data: bytes) -> Bye:
    if data:
        raise ProtocolError("bytes after a bye")
    return Bye()


def _encode_voice(body: VoicePayload) -> bytes:
    high, low = divmod(body.number & (1 << VOICE_NUMBER_BITS) - 1, 8)
    return bytes((VOICE_BIT | high, low << 5 | body.begins << 4 | body.format_number)) + body.data


def _decode_voice(data: bytes) -> VoicePayload:
    if len(data) <= _VOICE_FIELDS:
        raise ProtocolError("voice without data")
    number = (data[0] & VOICE_BIT - 1) << 3 | data[1] >> 5
    return VoicePayload(number, bool(data[1] >> 4 & 1), data[1] & 15, data[_VOICE_FIELDS:])


def _encode_voice_format(body: VoiceFormatMessage) -> bytes:
    voice = body.format
    flags = voice.fixed_size + 2 * voice.repeated
    fields = [body.format_number, voice.codec, voice.bit_rate, voice.frame_ms, voice.frames, flags]
    return bytes(msgpack.packb(fields))


def _decode_voice_format(data: bytes) -> VoiceFormatMessage:
    limits: dict[str, Any] = dict(max_array_len=6, max_map_len=0, max_ext_len=0, max_bin_len=0)
    try:
        fields = msgpack.unpackb(data, max_str_len=MAX_CODEC_NAME, **limits)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("a voice format is not msgpack") from error
    types = [int, str, int, int, int, int]
    if type(fields) is not list or [type(field) for field in fields] != types:
        raise ProtocolError("a voice format with fields of other types")
    number, codec, bit_rate, frame_ms, frames, flags = fields
    if not 0 <= number < MAX_FORMATS or flags < 0:
        raise ProtocolError("a voice format out of range")
    voice_format = VoiceFormat(codec, bit_rate, frame_ms, frames, bool(flags & 1), flags >> 1)
    voice_format.check()
    return VoiceFormatMessage(number, voice_format)


def _decode_voice_state(data: bytes) -> VoiceStateMessage:
    if len(data) != 2 or data[0] not in _VOICE_STATES or data[1] > MAX_NOISE_LEVEL:
        raise ProtocolError("not a voice state and a noise level")
    return VoiceStateMessage(VoiceState(data[0]), data[1])


def _encode_participant(body: ParticipantMessage) -> bytes:
    flags = body.camera.value | WITHDRAWN_BIT * body.is_portrait_withdrawn | body.head << HEAD_SHIFT
    return bytes((flags,)) + body.name.encode()


def _decode_participant(data: bytes) -> ParticipantMessage:
    if not 1 <= len(data) <= 1 + MAX_NAME_BYTES:
        raise ProtocolError("not a camera state and a name")
    try:
        name = data[1:].decode()
    except UnicodeDecodeError as error:
        raise ProtocolError("a name is not UTF-8") from error
    camera, is_withdrawn = CameraState(data[0] & CAMERA_BIT), bool(data[0] & WITHDRAWN_BIT)
    return ParticipantMessage(clean_name(name), camera, is_withdrawn, data[0] >> HEAD_SHIFT)


def _decode_furrows(data: bytes) -> FurrowMessage:
    if len(data) != 1:
        raise ProtocolError("not one byte of furrows")
    return FurrowMessage(data[0] & MAX_FURROW_LEVEL)


def _token(data: bytes) -> bytes:
    if len(data) != TOKEN_BYTES:
        raise ProtocolError(f"a token has {TOKEN_BYTES} bytes")
    return data


_VOICE_STATES = {state.value for state in VoiceState if state is not VoiceState.TALKING}  # the packets tell that
_PRESENCES = {presence.value for presence in Presence}
_ENCODERS: dict[type, tuple[int, Callable[[Any], bytes]]] = {
    StreamParameters: (PARAMETERS, _encode_parameters),
    KeepAlive: (KEEP_ALIVE, lambda body: msgpack.packb([round(body.timestamp * MILLISECONDS), body.presence.value])),
    RoundTripMessage: (ROUND_TRIP, lambda body: msgpack.packb([min(body.milliseconds, 0xFFFF)])),
    Bye: (BYE, lambda body: b""),
    PortraitChunk: (PORTRAIT_CHUNK, lambda body: body.data),
    PortraitAck: (PORTRAIT_ACK, lambda body: body.data),
    VoiceFormatMessage: (VOICE_FORMAT, _encode_voice_format),
    VoiceStateMessage: (VOICE_STATE, lambda body: bytes((body.state.value, body.noise_level))),
    ParticipantMessage: (PARTICIPANT, _encode_participant),
    FurrowMessage: (FURROWS, lambda body: bytes((body.level,))),
    PathProbe: (PATH_PROBE, lambda body: body.token),
    PathAnswer: (PATH_ANSWER, lambda body: body.token),
    PathCandidates: (PATH_CANDIDATES, encode_candidates),
}
_DECODERS: dict[int, Callable[[bytes], SingleBody]] = {
    PARAMETERS: _decode_parameters,
    KEEP_ALIVE: _decode_keep_alive,
    REPORT: lambda data: Feedback(decode_report(data), refresh=False),
    REFRESH_REPORT: lambda data: Feedback(decode_report(data), refresh=True),
    ROUND_TRIP: _decode_round_trip,
    BYE: _decode_bye,
    PORTRAIT_CHUNK: PortraitChunk,
    PORTRAIT_ACK: PortraitAck,
    VOICE_FORMAT: _decode_voice_format,
    VOICE_STATE: _decode_voice_state,
    PARTICIPANT: _decode_participant,
    PATH_PROBE: lambda data: PathProbe(_token(data)),
    PATH_ANSWER: lambda data: PathAnswer(_token(data)),
    PATH_CANDIDATES: decode_candidates,
    FURROWS: _decode_furrows,
}
