"""Read untrusted text files line by line in bounded memory, for PPC, DPC, EPC and OBJ."""

import codecs
import math
from collections.abc import Callable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import IO

from conf.errors import FileFormatError

MAX_FILE_BYTES = 64 << 20  # a mesh of a million vertices, or an hour of motion
_MAX_LINE_BYTES = 1 << 16
_SAMPLE_BYTES = 1 << 12  # of the start of a file, that show its encoding and line breaks
_MAX_NUMBER = 1e9  # larger than any coordinate of a face; its square still fits float32


def check_file(path: Path, /, *, max_bytes: int = MAX_FILE_BYTES) -> None:
    """Raise FileFormatError if the path is not a file, cannot be opened, or is larger than max_bytes."""
    try:
        if not path.is_file():
            raise FileFormatError(path, None, "expected a file; check the name")
        size = path.stat().st_size
    except (OSError, ValueError) as error:
        raise FileFormatError(path, None, f"cannot be opened: {error}") from error
    if size > max_bytes:
        raise FileFormatError(path, None, f"expected at most {max_bytes >> 20} MB, found {size >> 20} MB")


def read_lines(path: Path, /, *, on_long_line: Callable[[int], None] | None = None) -> Iterator[tuple[int, bytes]]:
    """Yield (line number from 1, line without its line break), whatever the program that wrote the file.

    A byte-order mark is dropped, as are Ctrl-Z and zeros at the end of a line, with which files of DOS programs end;
    UTF-16 becomes UTF-8, and lines may end as on Windows, Unix or old Macs.
    on_long_line : called with the number of a line that is too long, which is then left out
    Raises FileFormatError if the file cannot be read, or a line is too long.
    """
    check_file(path)
    try:
        with path.open("rb") as raw:
            file: IO[bytes] = raw
            start = raw.read(_SAMPLE_BYTES)
            if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
                text = (start + raw.read()).decode("utf-16", "replace").encode("utf-8")
                file = BytesIO(text.replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
            elif b"\r" in start and b"\n" not in start:
                file = BytesIO((start + raw.read()).replace(b"\r", b"\n"))
            else:
                raw.seek(len(codecs.BOM_UTF8) if start.startswith(codecs.BOM_UTF8) else 0)
            number = 0
            while line := file.readline(_MAX_LINE_BYTES):
                number += 1
                if len(line) == _MAX_LINE_BYTES and not line.endswith(b"\n"):
                    if on_long_line is None:
                        raise FileFormatError(path, number, f"expected text lines under {_MAX_LINE_BYTES} bytes")
                    on_long_line(number)
                    while line and not line.endswith(b"\n"):
                        line = file.readline(_MAX_LINE_BYTES)
                    continue
                yield number, line.rstrip(b"\r\n\x1a\0")
    except OSError as error:
        raise FileFormatError(path, None, f"cannot be read: {error}") from error


def decode_name(data: bytes, /) -> str:
    """Return a name in a file: UTF-8, or else in the encoding of Western Windows programs."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_floats(words: Sequence[bytes], path: Path, line: int, expected: str) -> list[float]:
    """Return the words, which may have decimal commas, as finite numbers.

    Raises FileFormatError with the message `expected` if one is not a number, or not within the limit.
    """
    try:
        values = [float(word.replace(b",", b".", 1)) for word in words]
    except ValueError as error:
        raise FileFormatError(path, line, expected) from error
    if not all(math.isfinite(value) and abs(value) <= _MAX_NUMBER for value in values):
        raise FileFormatError(path, line, f"{expected}, each finite and at most {_MAX_NUMBER:g}")
    return values
