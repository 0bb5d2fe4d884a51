import struct
from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import CameraError
from conf.sender.capture.clip import open_clip
from conf.sender.capture.mp4_index import claims_more_than_it_holds
from tests.support.generated_clips import write_clip


def box(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I4s", 8 + len(content), kind) + content


def with_table(table: bytes) -> BytesIO:
    tracks = box(b"trak", box(b"tkhd", bytes(84)) + box(b"mdia", box(b"minf", box(b"stbl", table))))
    return BytesIO(box(b"ftyp", b"isom0000") + box(b"moov", tracks + tracks) + box(b"mdat", bytes(1000)))


def stsz(size: int, count: int) -> bytes:
    return box(b"stsz", struct.pack(">III", 0, size, count))


def trun(flags: int, count: int) -> bytes:
    return box(b"trun", struct.pack(">III", flags, count, 0))


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (stsz(166, 5), False), (stsz(166, 79_784_806), True), (stsz(0, 5), False), (stsz(0, 5000), True),
        (stsz(1, 5000), False), (stsz(1, 50_000), True), (box(b"stsz", b""), False), (b"", False), (b"abc", False),
        (trun(0x200, 2**31), False), (trun(0, 10), False), (trun(1, 2**31), True),
        (struct.pack(">I4s", 3, b"stsz"), False), (struct.pack(">I4s", 0, b"free") + bytes(20), False),
        (struct.pack(">I4sQ", 1, b"free", 40) + bytes(24) + stsz(9, 9999), True),
    ],
)  # fmt: skip
def test_an_index_of_more_samples_than_bytes_is_found(table: bytes, expected: bool) -> None:
    file = with_table(table)
    file.seek(3)
    assert claims_more_than_it_holds(file) is expected and file.tell() == 3


def test_other_files_are_not_searched() -> None:
    assert not claims_more_than_it_holds(BytesIO(b"RIFF" + stsz(166, 2**31)))
    assert not claims_more_than_it_holds(BytesIO(b""))


def test_such_a_clip_is_refused_before_memory_is_allocated(tmp_path: Path) -> None:
    content = bytearray(write_clip(tmp_path / "clip.mp4", [0.0, 0.04]).read_bytes())
    assert not claims_more_than_it_holds(BytesIO(content))
    at = content.index(b"stsz") + 8
    content[at : at + 8] = struct.pack(">II", 166, 79_784_806)
    (tmp_path / "huge.mp4").write_bytes(bytes(content))
    with pytest.raises(CameraError, match=r"can be read \(its index names more frames than it has bytes\)"):
        open_clip(tmp_path / "huge.mp4")


@given(st.binary(max_size=200))
def test_any_bytes_are_searched(content: bytes) -> None:
    assert claims_more_than_it_holds(BytesIO(box(b"moov", content))) in (False, True)
