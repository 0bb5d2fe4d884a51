"""Message bodies, the content of a sealed datagram, to bytes and back. WIRE.md describes each.

Strategy. The first byte is the kind. Motion is nearly all of the traffic, so its kind takes one byte together with the
low seven bits of the frame number. Every other body is a kind below 128 and, for most, one msgpack array of small
integers. `decode_body` returns a body or raises ProtocolError, whatever the bytes: any other exception is a bug.
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

NUMBER_BITS = 7
MOTION_BIT = 1 << NUMBER_BITS
MAX_BODY = 1100
MAX_POINTS = 64
MILLISECONDS = 1000  # per second
FAPU_STEPS = 1000  # per centimetre
FPS_STEPS = 100
PARAMETERS, KEEP_ALIVE, REPORT, ROUND_TRIP, BYE, PORTRAIT_CHUNK, PORTRAIT_ACK, MOTION_WITH_CHUNK = range(8)


def encode_body(body: Body) -> bytes:
    """Return the bytes of a body."""
    if isinstance(body, MotionPayload):
        return bytes((MOTION_BIT | body.frame_number & (MOTION_BIT - 1),)) + body.payload
    kind, encode = _ENCODERS[type(body)]
    return bytes((kind,)) + encode(body)


def decode_body(data: bytes) -> Body:
    """Return the body. Raises ProtocolError."""
    if not 0 < len(data) <= MAX_BODY:
        raise ProtocolError("a body is empty or too long")
    if data[0] & MOTION_BIT:
        return MotionPayload(data[0] & (MOTION_BIT - 1), data[1:])
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


def _decode_feedback(data: bytes) -> Feedback:
    if len(data) < 2 or data[0] > 1:
        raise ProtocolError("a report without its flag")
    return Feedback(decode_report(data[1:]), bool(data[0]))


def _decode_round_trip(data: bytes) -> RoundTripMessage:
    (milliseconds,) = _unpack(data, 1)
    if milliseconds > 0xFFFF:
        raise ProtocolError("a round trip of more than a minute")
    return RoundTripMessage(milliseconds)


def _decode_bye(data: bytes) -> Bye:
    if data:
        raise ProtocolError("bytes after a bye")
    return Bye()


def _encode_motion_with_chunk(body: MotionWithChunk) -> bytes:
    motion = encode_body(body.motion)
    return bytes((len(motion),)) + motion + body.chunk.data


def _decode_motion_with_chunk(data: bytes) -> MotionWithChunk:
    end = 1 + data[0] if data else 1
    if not 1 < end < len(data) or not data[1] & MOTION_BIT:
        raise ProtocolError("not motion and a chunk")
    return MotionWithChunk(MotionPayload(data[1] & (MOTION_BIT - 1), data[2:end]), PortraitChunk(data[end:]))


_PRESENCES = {presence.value for presence in Presence}
_ENCODERS: dict[type, tuple[int, Callable[[Any], bytes]]] = {
    StreamParameters: (PARAMETERS, _encode_parameters),
    KeepAlive: (KEEP_ALIVE, lambda body: msgpack.packb([round(body.timestamp * MILLISECONDS), body.presence.value])),
    Feedback: (REPORT, lambda body: bytes((body.refresh,)) + encode_report(body.report)),
    RoundTripMessage: (ROUND_TRIP, lambda body: msgpack.packb([min(body.milliseconds, 0xFFFF)])),
    Bye: (BYE, lambda body: b""),
    PortraitChunk: (PORTRAIT_CHUNK, lambda body: body.data),
    PortraitAck: (PORTRAIT_ACK, lambda body: body.data),
    MotionWithChunk: (MOTION_WITH_CHUNK, _encode_motion_with_chunk),
}
_DECODERS: dict[int, Callable[[bytes], Body]] = {
    PARAMETERS: _decode_parameters,
    KEEP_ALIVE: _decode_keep_alive,
    REPORT: _decode_feedback,
    ROUND_TRIP: _decode_round_trip,
    BYE: _decode_bye,
    PORTRAIT_CHUNK: PortraitChunk,
    PORTRAIT_ACK: PortraitAck,
    MOTION_WITH_CHUNK: _decode_motion_with_chunk,
}
