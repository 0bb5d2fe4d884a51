"""Check the index of MP4 and MOV files before FFmpeg allocates memory for as many samples as it claims.

Source: ISO/IEC 14496-12, 8.7.3 (stsz), 8.8.8 (trun).
"""

import struct
from collections.abc import Iterator
from typing import IO

_CONTAINERS = frozenset((b"moov", b"trak", b"mdia", b"minf", b"stbl", b"moof", b"traf"))
_FIRST = frozenset((b"ftyp", b"styp", b"moov", b"moof", b"mdat", b"free", b"skip", b"wide", b"pnot", b"sidx"))
_MAX_BOXES = 100_000
_SAMPLE_FIELDS = 0xF00  # flags of trun: each sample has data of its own in the box
_MAX_OLD_SOUND_RATIO = 16  # samples a byte: QuickTime counts those of compressed sound as one byte each
_MAX_SAMPLES = 1 << 20  # without data of their own: an hour of sound in one fragment has a fifth of this


def claims_more_than_it_holds(file: IO[bytes], /) -> bool:
    """Return whether a file is MP4 and names more samples than it has bytes. The position in the file is kept."""
    start = file.tell()
    size = file.seek(0, 2)
    try:
        return any(_is_impossible(kind, head, size) for kind, head in _boxes(file, size))
    finally:
        file.seek(start)


def _boxes(file: IO[bytes], size: int) -> Iterator[tuple[bytes, bytes]]:
    """Yield the kind of each box and the first twelve bytes of its content."""
    ends, at = [size], 0
    for number in range(_MAX_BOXES):
        while at + 8 > ends[-1]:
            if len(ends) == 1:
                return
            at = ends.pop()
        file.seek(at)
        head = file.read(28)
        length, kind = struct.unpack_from(">I4s", head)
        if number == 0 and kind not in _FIRST:
            return
        header = 8
        if length == 1 and len(head) >= 16:
            (length,), header = struct.unpack_from(">Q", head, 8), 16
        end = min(at + length, ends[-1]) if length else ends[-1]
        if length and length < header:
            at = ends[-1]
            continue
        yield kind, head[header : min(header + 12, end - at)]
        if kind in _CONTAINERS:
            ends.append(end)
            at += header
        else:
            at = end


def _is_impossible(kind: bytes, head: bytes, size: int) -> bool:
    if len(head) < 12:
        return False
    flags, first, second = struct.unpack(">III", head)
    if kind == b"stsz":  # size of all samples, or 0 and a table; number of samples
        return bool(second > _MAX_OLD_SOUND_RATIO * size if first == 1 else max(first, 4) * second > size)
    return bool(kind == b"trun" and not flags & _SAMPLE_FIELDS and first > _MAX_SAMPLES)
