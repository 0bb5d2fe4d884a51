"""The bare VP8 frame of a WebP file: 20 bytes shorter, and its size is known before it is decoded.

Source: RFC 9649 (WebP container), RFC 6386 section 9.1 (VP8 frame header).
"""

import struct

from conf.errors import ProtocolError

_RIFF = struct.Struct("<4sI4s4sI")
_START_CODE = b"\x9d\x01\x2a"
_HEADER = 10  # bytes of a key frame's header
MAX_SIDE = 1024  # px
MAX_PIXELS = 640 * 640


def strip_riff(webp: bytes, /) -> bytes:
    """Return the VP8 frame of a simple lossy WebP file. Raises ValueError if the file is of another kind."""
    if len(webp) < _RIFF.size:
        raise ValueError("webp must be a WebP file")
    riff, _, name, chunk, size = _RIFF.unpack_from(webp)
    if (riff, name, chunk) != (b"RIFF", b"WEBP", b"VP8 "):
        raise ValueError("webp must be a simple lossy WebP file")
    return webp[_RIFF.size : _RIFF.size + size]


def wrap_riff(frame: bytes, /) -> bytes:
    """Return the WebP file of a VP8 frame."""
    padded = frame + b"\0" * (len(frame) % 2)
    return _RIFF.pack(b"RIFF", len(padded) + _RIFF.size - 8, b"WEBP", b"VP8 ", len(frame)) + padded


def read_frame_size(frame: bytes, /) -> tuple[int, int]:
    """Return width and height of a VP8 key frame in pixels. Raises ProtocolError if it must not be decoded."""
    if len(frame) < _HEADER or frame[0] & 1 or frame[3:6] != _START_CODE:
        raise ProtocolError("not a VP8 key frame")
    width, height = (number & 0x3FFF for number in struct.unpack_from("<HH", frame, 6))
    if not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE and width * height <= MAX_PIXELS):
        raise ProtocolError(f"an image of {width} x {height} is too large")
    first_partition = (frame[0] | frame[1] << 8 | frame[2] << 16) >> 5
    if first_partition > len(frame) - _HEADER:
        raise ProtocolError("an image cut off")
    return width, height
