"""What lies under the seal: message bodies to bytes and back. WIRE.md describes each.

Strategy. The first byte says what follows. Motion is nearly all of the traffic, so it takes one byte and no more: the
high bit, and the low seven bits of the first frame's number. Everything else is a kind below 128 and one msgpack array
of small integers. `decode_body` returns a body or raises ProtocolError, whatever the bytes: another exception is a bug.
"""

from collections.abc import Callable
from typing import Any

import msgpack

from conf.errors import ProtocolError
from conf.protocol.feedback import decode_report, encode_report
from conf.protocol.messages import (
    Body,
    Bye,
    Feedback,
    KeepAlive,
    MotionPayload,
    MotionWithChunk,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    StreamParameters,
)

MOTION_BIT = 0x80
NUMBER_BITS = 7
MAX_BODY = 1100
MAX_POINTS = 64
MILLISECONDS = 1000
FAPU_STEPS = 1000  # a centimetre
PARAMETERS, KEEP_ALIVE, REPORT, ROUND_TRIP, BYE, PORTRAIT_CHUNK, PORTRAIT_ACK, MOTION_WITH_CHUNK = range(8)


def encode_body(body: Body) -> bytes:
    """Return the bytes of a body."""
    if isinstance(body, MotionPayload):
        return bytes((MOTION_BIT | body.frame_number & (MOTION_BIT - 1),)) + body.payload
    kind, rest = _ENCODERS[type(body)](body)
    return bytes((kind,)) + rest


def decode_body(data: bytes) -> Body:
    """Return the body, or raise ProtocolError with the reason."""
    if not 0 < len(data) <= MAX_BODY:
        raise ProtocolError("a body is empty or too long")
    if data[0] & MOTION_BIT:
        return MotionPayload(data[0] & (MOTION_BIT - 1), data[1:])
    decoder = _DECODERS.get(data[0])
    if decoder is None:
        raise ProtocolError(f"unknown kind {data[0]}")
    return decoder(data[1:])


def _integers(data: bytes, count: int) -> list[int]:
    try:
        array = msgpack.unpackb(data, max_array_len=count, max_map_len=0, max_ext_len=0, max_str_len=0, max_bin_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("not msgpack") from error
    if type(array) is not list or len(array) != count:
        raise ProtocolError(f"not an array of {count}")
    if any(type(n) is not int or not 0 <= n < 1 << 48 for n in array):
        raise ProtocolError("a field is not a small integer")
    return array


def _encode_parameters(body: StreamParameters) -> tuple[int, bytes]:
    fapu = [round(distance * FAPU_STEPS) for distance in body.fapu]
    numbers = [round(body.clock * MILLISECONDS), body.width, body.height, round(body.fps * 100), body.points, *fapu]
    return PARAMETERS, msgpack.packb(numbers)


def _decode_parameters(data: bytes) -> StreamParameters:
    clock, width, height, rate, points, *fapu = _integers(data, 10)
    if not (0 < width <= 16384 and 0 < height <= 16384 and 0 < rate <= 24000 and 0 < points <= MAX_POINTS):
        raise ProtocolError("stream parameters out of range")
    if not all(0 < distance <= 0xFFFF for distance in fapu):
        raise ProtocolError("a FAPU distance out of range")
    return StreamParameters(
        width, height, rate / 100, points, tuple(distance / FAPU_STEPS for distance in fapu), clock / MILLISECONDS
    )


def _encode_keep_alive(body: KeepAlive) -> tuple[int, bytes]:
    return KEEP_ALIVE, msgpack.packb([round(body.timestamp * MILLISECONDS), body.presence.value])


def _decode_keep_alive(data: bytes) -> KeepAlive:
    clock, presence = _integers(data, 2)
    if presence not in _PRESENCES:
        raise ProtocolError("unknown presence")
    return KeepAlive(clock / MILLISECONDS, Presence(presence))


def _encode_feedback(body: Feedback) -> tuple[int, bytes]:
    return REPORT, bytes((body.refresh,)) + encode_report(body.report)


def _decode_feedback(data: bytes) -> Feedback:
    if len(data) < 2 or data[0] > 1:
        raise ProtocolError("a report without its flag")
    return Feedback(decode_report(data[1:]), bool(data[0]))


def _encode_round_trip(body: RoundTripMessage) -> tuple[int, bytes]:
    return ROUND_TRIP, msgpack.packb([min(body.milliseconds, 0xFFFF)])


def _decode_round_trip(data: bytes) -> RoundTripMessage:
    (milliseconds,) = _integers(data, 1)
    if milliseconds > 0xFFFF:
        raise ProtocolError("a round trip of more than a minute")
    return RoundTripMessage(milliseconds)


def _encode_goodbye(body: Bye) -> tuple[int, bytes]:
    return BYE, b""


def _decode_goodbye(data: bytes) -> Bye:
    if data:
        raise ProtocolError("a goodbye with more to say")
    return Bye()


def _encode_together(body: MotionWithChunk) -> tuple[int, bytes]:
    motion = encode_body(body.motion)
    return MOTION_WITH_CHUNK, bytes((len(motion),)) + motion + body.chunk.data


def _decode_together(data: bytes) -> MotionWithChunk:
    end = 1 + data[0] if data else 1
    if not 1 < end < len(data) or not data[1] & MOTION_BIT:
        raise ProtocolError("not motion and a piece")
    return MotionWithChunk(MotionPayload(data[1] & (MOTION_BIT - 1), data[2:end]), PortraitChunk(data[end:]))


_PRESENCES = {presence.value for presence in Presence}
_ENCODERS: dict[type, Callable[[Any], tuple[int, bytes]]] = {
    StreamParameters: _encode_parameters,
    KeepAlive: _encode_keep_alive,
    Feedback: _encode_feedback,
    RoundTripMessage: _encode_round_trip,
    Bye: _encode_goodbye,
    MotionWithChunk: _encode_together,
    PortraitChunk: lambda body: (PORTRAIT_CHUNK, body.data),
    PortraitAck: lambda body: (PORTRAIT_ACK, body.data),
}
_DECODERS: dict[int, Callable[[bytes], Body]] = {
    PARAMETERS: _decode_parameters,
    KEEP_ALIVE: _decode_keep_alive,
    REPORT: _decode_feedback,
    ROUND_TRIP: _decode_round_trip,
    BYE: _decode_goodbye,
    PORTRAIT_CHUNK: PortraitChunk,
    MOTION_WITH_CHUNK: _decode_together,
    PORTRAIT_ACK: PortraitAck,
}
