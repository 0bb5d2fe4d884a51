from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.formats.ppc import read_ppc, write_ppc
from tests.support.sheet_face import SheetFace


def test_points_are_read_back(tmp_path: Path, face: SheetFace) -> None:
    path = tmp_path / "face.ppc"
    write_ppc(path, face.points)
    assert read_ppc(path) == pytest.approx(face.points, abs=1e-6)
    assert "16 3.5 pupil_l" in path.read_text()


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", None, "expected 50 control points, found 0"),
        ("1 2 3\n" * 49, None, "expected 50 control points, found 49"),
        ("# 1\n" + "1 2 3\n" * 51, 52, "expected the file to end after 50 points"),
        ("1 2 3\n1 2\n", 2, "expected `x y z`, the position of one control point"),
        ("1 2 z\n", 1, "expected `x y z`"),
        ("1 2 inf\n", 1, "each finite"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, text: str, line: int | None, expected: str) -> None:
    path = tmp_path / "bad.ppc"
    path.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_ppc(path)
    assert caught.value.line == line
    assert expected in str(caught.value)


@pytest.mark.slow
@given(st.one_of(st.binary(max_size=400), st.text("0123456789.-e# \nx", max_size=600).map(str.encode)))
def test_any_bytes_give_points_or_file_format_error(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.ppc"
    path.write_bytes(data)
    try:
        points = read_ppc(path)
    except FileFormatError:
        return
    assert points.shape == (50, 3)
    assert np.isfinite(points).all()


def test_only_finite_positions_are_written(tmp_path: Path) -> None:
    for points in (np.zeros((49, 3)), np.full((50, 3), np.nan)):
        with pytest.raises(ValueError, match="points must be 50 finite positions"):
            write_ppc(tmp_path / "bad.ppc", points)
