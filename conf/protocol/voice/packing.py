"""The frames of a voice packet as bytes.

A fixed-size codec: the bits of all frames, highest first, without gaps, then zero bits up to a whole byte. A
variable-size codec: each frame but the last after a byte that is its length; an empty frame is a lost one.
"""

from collections.abc import Sequence

from conf.errors import ProtocolError
from conf.protocol.voice.formats import MAX_VARIABLE_FRAME, VoiceFormat


def pack_frames(frames: Sequence[bytes], voice_format: VoiceFormat, /) -> bytes:
    """Return the data of a packet. Raises ValueError if a frame does not have the format's size."""
    if voice_format.fixed_size:
        return _pack_fixed(frames, voice_format.frame_bits)
    if any(len(frame) > MAX_VARIABLE_FRAME for frame in frames):
        raise ValueError(f"a voice frame is longer than {MAX_VARIABLE_FRAME} bytes")
    return b"".join(bytes((len(frame),)) + frame for frame in frames[:-1]) + frames[-1]


def unpack_frames(data: bytes, voice_format: VoiceFormat, count: int, /) -> list[bytes]:
    """Return `count` frames, an empty one where a variable-size codec sent none. Raises ProtocolError."""
    if voice_format.fixed_size:
        return _unpack_fixed(data, voice_format.frame_bits, count)
    frames = []
    at = 0
    for _ in range(count - 1):
        end = at + 1 + data[at] if at < len(data) else len(data) + 1
        if end > len(data):
            raise ProtocolError("a voice packet cut off")
        frames.append(data[at + 1 : end])
        at = end
    return [*frames, data[at:]]


def _pack_fixed(frames: Sequence[bytes], bits: int) -> bytes:
    size, joined = -(-bits // 8), 0
    for frame in frames:
        if len(frame) != size:
            raise ValueError(f"a voice frame of {bits} bits has {size} bytes, not {len(frame)}")
        joined = joined << bits | int.from_bytes(frame) >> 8 * size - bits
    total = bits * len(frames)
    return (joined << -total % 8).to_bytes(-(-total // 8))


def _unpack_fixed(data: bytes, bits: int, count: int) -> list[bytes]:
    total, size = bits * count, -(-bits // 8)
    joined, padding = int.from_bytes(data), -total % 8
    if len(data) != -(-total // 8) or joined & (1 << padding) - 1:
        raise ProtocolError("a voice packet of the wrong length")
    joined >>= padding
    mask = (1 << bits) - 1
    return [((joined >> bits * i & mask) << 8 * size - bits).to_bytes(size) for i in range(count - 1, -1, -1)]
