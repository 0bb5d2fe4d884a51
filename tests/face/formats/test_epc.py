from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.formats.dpc import read_dpc
from conf.face.formats.epc import MAX_NAME, ExpressionSet, is_name, read_epc, write_epc

ROW = "0.1 -2 3\n"
FRAME = ROW * CONTROL_POINT_COUNT
same_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def expressions(names: tuple[str, ...], seed: int = 0) -> ExpressionSet:
    displacements = np.random.default_rng(seed).uniform(-1500, 1500, (len(names), CONTROL_POINT_COUNT, 3))
    return ExpressionSet(names, displacements.round(1).astype(np.float32))


@pytest.mark.slow
@same_folder
@given(names=st.lists(st.text(max_size=MAX_NAME).filter(is_name), min_size=1, max_size=4, unique=True))
def test_expressions_are_read_back(tmp_path: Path, names: list[str]) -> None:
    written = expressions(tuple(names))
    write_epc(tmp_path / "a.epc", written, comments=["a comment: with a colon"])
    read = read_epc(tmp_path / "a.epc")
    assert read.names == written.names
    assert read.units == "fapu"
    np.testing.assert_allclose(read.displacements, written.displacements, atol=0.051)
    np.testing.assert_array_equal(read[names[-1]], read.displacements[-1])


def test_an_epc_file_is_a_dpc_file(tmp_path: Path) -> None:
    write_epc(tmp_path / "a.epc", expressions(("joy", "fear")))
    motion = read_dpc(tmp_path / "a.epc")
    assert motion.units == "fapu"
    np.testing.assert_array_equal(motion.displacements, read_epc(tmp_path / "a.epc").displacements)


@pytest.mark.parametrize(("frames", "names"), [(1, ("joy",)), (2, ("joy 1", "joy 2"))])
def test_frames_without_a_name_are_named_after_the_file(tmp_path: Path, frames: int, names: tuple[str, ...]) -> None:
    (tmp_path / "joy.epc").write_text(f"{frames} # quadros\n" + FRAME * frames)
    read = read_epc(tmp_path / "joy.epc")
    assert read.names == names
    assert read.units == "mesh"


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("1\n" + ROW * 49, None, "expected 50 control points a frame, found 49"),
        ("1\n" + ROW + "# name: late\n" + ROW * 49, 3, "before the first line of the frame"),
        ("1\n# name: a\n# name: b\n" + FRAME, 3, "expected `# name:` once"),
        ("1\n# name:\n" + FRAME, 2, "printable characters"),
        ("1\n# name: \xff\n" + FRAME, 2, "printable characters"),
        ("2\n# name: a\n" + FRAME + "# name: a\n" + FRAME, None, "a different name for each frame"),
        ("x\n", 1, "expected the number of frames"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, text: str, line: int | None, expected: str) -> None:
    path = tmp_path / "bad.epc"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileFormatError) as error:
        read_epc(path)
    assert expected in error.value.expected
    assert error.value.line == line
    assert str(path) in str(error.value)


def test_a_huge_file_is_rejected_by_its_size(tmp_path: Path) -> None:
    path = tmp_path / "huge.epc"
    with path.open("wb") as file:
        file.truncate(100 << 20)
    with pytest.raises(FileFormatError, match="at most 8 MB"):
        read_epc(path)


pieces = st.sampled_from([b"1\n", b"2\n", b"# name: joy\n", b"# name:", b"# units: fapu\n", b"# points: 50\n", b"...\n",
                          b"# name: \xc3\n", FRAME.encode(), ROW.encode(), b"nan 0 0\n", b"\x00"])  # fmt: skip


@pytest.mark.slow
@same_folder
@given(data=st.one_of(st.binary(max_size=300), st.lists(pieces, max_size=8).map(b"".join)))
def test_any_bytes_give_expressions_or_file_format_error(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.epc").write_bytes(data)
    try:
        read = read_epc(tmp_path / "a.epc")
    except FileFormatError:
        return
    assert read.displacements.shape == (len(read.names), CONTROL_POINT_COUNT, 3)
    assert np.isfinite(read.displacements).all()
    assert all(map(is_name, read.names))


@pytest.mark.parametrize("name", ["", " joy", "a#b", "a\nb", "x" * 61])
def test_invalid_names_are_not_written(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="names must be"):
        write_epc(tmp_path / "a.epc", expressions((name,)))


def test_an_unknown_name_is_a_key_error() -> None:
    with pytest.raises(KeyError):
        expressions(("joy",))["fear"]


def test_mesh_units_are_converted_to_fapu() -> None:
    fapu = Fapu(es0=64.0, ens0=48.0, mns0=26.0, mw0=51.0, irisd0=9.7)  # a face in millimetres
    fapu_set = expressions(("joy",))
    mesh = ExpressionSet(("joy",), (fapu_set.displacements * fapu.lengths()).astype(np.float32), "mesh")
    assert fapu_set.in_fapu(fapu) is fapu_set
    assert mesh.in_fapu(fapu).units == "fapu"
    np.testing.assert_allclose(mesh.in_fapu(fapu)["joy"], fapu_set["joy"], rtol=1e-5, atol=1e-3)
