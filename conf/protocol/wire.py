"""Datagrams to messages and back: the only module that knows the bytes. WIRE.md is its description.

Strategy. `decode` returns a message or raises ProtocolError, whatever the bytes: any other exception is a bug. A
datagram is one msgpack array of small integers and one `bin`, version first; what it carries is checked here once, so
that everything behind it may trust a message.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np

from conf.errors import ProtocolError
from conf.protocol.fixed_point import decode_motion, encode_motion
from conf.protocol.messages import KeepAlive, MotionFrame, Presence, StreamParameters

VERSION = 1
MAX_DATAGRAM = 1200
MAX_POINTS = 64
FAPU_STEP_CM = 1e-3
MILLISECONDS = 1000

PARAMETERS, MOTION, KEEP_ALIVE = 0, 1, 2

Message = StreamParameters | MotionFrame | KeepAlive


@dataclass(frozen=True)
class Datagram:
    """A message with its place in the stream."""

    sequence: int
    message: Message


def encode(datagram: Datagram) -> bytes:
    """Return the bytes of a datagram."""
    kind, fields, blob = _ENCODERS[type(datagram.message)](datagram.message)
    data: bytes = msgpack.packb([VERSION, kind, datagram.sequence, *fields, blob], use_bin_type=True)
    return data


def decode(data: bytes) -> Datagram:
    """Return the datagram, or raise ProtocolError with the reason."""
    version, kind, sequence, *fields, blob = _unpack(data)
    if version != VERSION:
        raise ProtocolError(f"version {version}, this is {VERSION}")
    if kind not in _DECODERS:
        raise ProtocolError(f"unknown kind {kind}")
    count, decoder = _DECODERS[kind]
    if len(fields) != count:
        raise ProtocolError(f"kind {kind} has {len(fields)} fields, not {count}")
    return Datagram(sequence, decoder(fields, blob))


def _unpack(data: bytes) -> list[Any]:
    if not 0 < len(data) <= MAX_DATAGRAM:
        raise ProtocolError("empty or oversized")
    try:
        array = msgpack.unpackb(data, raw=False, max_array_len=16, max_map_len=0, max_ext_len=0, max_str_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("not msgpack") from error
    if type(array) is not list or len(array) < 4 or type(array[-1]) is not bytes:
        raise ProtocolError("not an array that ends in a bin")
    if any(type(n) is not int or not 0 <= n < 1 << 48 for n in array[:-1]):
        raise ProtocolError("a field is not a small integer")
    return array


def _encode_parameters(message: StreamParameters) -> tuple[int, list[int], bytes]:
    fapu = np.rint(np.array(message.fapu) / FAPU_STEP_CM).astype(">u2").tobytes()
    rate = round(message.fps * 100)
    return PARAMETERS, [message.width, message.height, rate, message.points], fapu


def _decode_parameters(fields: list[int], blob: bytes) -> StreamParameters:
    width, height, rate, points = fields
    if not (0 < width <= 16384 and 0 < height <= 16384 and 0 < rate <= 24000 and 0 < points <= MAX_POINTS):
        raise ProtocolError("stream parameters out of range")
    fapu = np.frombuffer(blob, dtype=">u2") * FAPU_STEP_CM if len(blob) == 10 else np.zeros(1)
    if not fapu.all():
        raise ProtocolError("FAPU of the wrong number or zero")
    return StreamParameters(width, height, rate / 100, points, tuple(fapu.tolist()))


def _encode_motion(message: MotionFrame) -> tuple[int, list[int], bytes]:
    points = len(message.displacements)
    stamp = round(message.timestamp * MILLISECONDS)
    return MOTION, [stamp, points], encode_motion(message.displacements, message.pose)


def _decode_motion(fields: list[int], blob: bytes) -> MotionFrame:
    stamp, points = fields
    if not 0 < points <= MAX_POINTS:
        raise ProtocolError("number of points out of range")
    displacements, pose = decode_motion(blob, points)
    if math.hypot(*pose[:3]) > 2 * math.pi:
        raise ProtocolError("rotation beyond a full turn")
    return MotionFrame(stamp / MILLISECONDS, displacements, pose)


def _encode_keep_alive(message: KeepAlive) -> tuple[int, list[int], bytes]:
    return KEEP_ALIVE, [round(message.timestamp * MILLISECONDS), message.presence.value], b""


def _decode_keep_alive(fields: list[int], blob: bytes) -> KeepAlive:
    stamp, presence = fields
    if blob or presence not in (p.value for p in Presence):
        raise ProtocolError("keep-alive with a body or an unknown presence")
    return KeepAlive(stamp / MILLISECONDS, Presence(presence))


_ENCODERS: dict[type, Callable[[Any], tuple[int, list[int], bytes]]] = {
    StreamParameters: _encode_parameters,
    MotionFrame: _encode_motion,
    KeepAlive: _encode_keep_alive,
}
_DECODERS: dict[int, tuple[int, Callable[[list[int], bytes], Message]]] = {
    PARAMETERS: (4, _decode_parameters),
    MOTION: (2, _decode_motion),
    KEEP_ALIVE: (2, _decode_keep_alive),
}
