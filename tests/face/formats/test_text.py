import os
import resource
import time
from pathlib import Path

import pytest

from conf.errors import FileFormatError
from conf.face.formats.dpc import read_dpc
from conf.face.formats.ppc import read_ppc
from conf.face.formats.text import check_file, parse_floats, read_lines
from conf.face.mesh.mesh import load_mesh

GARBAGE = {
    "zeros": b"\x00" * 1024,
    "one long line": b"1 2 3 " * 170,
    "random": bytes(range(1, 256)) * 4,
    "comments": b"# nothing\n" * 100,
    "vertices": b"v 0 0 0\n" * 128,
    "numbers": b"1 2 3\n" * 170,
}


@pytest.mark.slow
@pytest.mark.parametrize("garbage", GARBAGE.values(), ids=GARBAGE)
@pytest.mark.parametrize(("reader", "suffix"), [(load_mesh, "obj"), (read_ppc, "ppc"), (read_dpc, "dpc")])
def test_a_hundred_megabytes_are_rejected_quickly(tmp_path: Path, reader: object, suffix: str, garbage: bytes) -> None:
    path = tmp_path / f"garbage.{suffix}"
    with path.open("wb") as file:
        for _ in range(100):
            file.write(garbage * (1_000_000 // len(garbage)))
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    with pytest.raises(FileFormatError, match="expected"):
        reader(path)  # type: ignore[operator]
    assert time.process_time() - start < 1.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB
    path.unlink()


def test_lines_are_numbered_from_one_for_any_line_break(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"a\r\nb\n\nc")
    assert list(read_lines(path)) == [(1, b"a"), (2, b"b"), (3, b""), (4, b"c")]


@pytest.mark.parametrize("end", [b"\x1a", b"\r\n\x1a", b"\n\x1a\0\0\0", b"\0"])
def test_the_end_mark_of_old_programs_is_dropped(tmp_path: Path, end: bytes) -> None:
    (tmp_path / "text").write_bytes(b"1 2\n3 4" + end)
    assert [line for _, line in read_lines(tmp_path / "text") if line] == [b"1 2", b"3 4"]


def test_long_lines_are_an_error_or_left_out(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"a\n" + b"x" * 200_000 + b"\nb\n" + b"y" * 70_000)
    with pytest.raises(FileFormatError, match="line 2: expected text lines under 65536 bytes"):
        list(read_lines(path))
    long_lines: list[int] = []
    assert list(read_lines(path, on_long_line=long_lines.append)) == [(1, b"a"), (3, b"b")]
    assert long_lines == [2, 4]


def test_numbers_may_have_decimal_commas() -> None:
    assert parse_floats([b"1,5", b"-2.5e1"], Path("f.txt"), 7, "a length") == [1.5, -25.0]


@pytest.mark.parametrize("kind", ["missing", "folder", "pipe", "nul\x00name"])
def test_what_is_not_a_file_is_rejected_without_blocking(tmp_path: Path, kind: str) -> None:
    path = tmp_path / kind
    if kind == "folder":
        path.mkdir()
    if kind == "pipe":
        os.mkfifo(path)
    with pytest.raises(FileFormatError, match=r"expected a file; check the name|cannot be opened"):
        list(read_lines(path))


def test_a_file_over_the_limit_is_rejected_by_its_size(tmp_path: Path) -> None:
    path = tmp_path / "large"
    path.write_bytes(b"x" * (3 << 20))
    with pytest.raises(FileFormatError, match="expected at most 1 MB, found 3 MB"):
        check_file(path, max_bytes=1 << 20)


@pytest.mark.parametrize("word", [b"x", b"", b"nan", b"inf", b"-1e10", b"1e400"])
def test_numbers_must_be_finite_and_within_the_limit(word: bytes) -> None:
    with pytest.raises(FileFormatError, match=r"f\.txt, line 7: expected a length"):
        parse_floats([b"1", word], Path("f.txt"), 7, "expected a length")
