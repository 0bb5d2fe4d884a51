import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.formats.obj import RawMesh, read_obj

EXAMPLE = """# a square of two materials, its corners in every notation of the format
mtllib square.mtl
o square
v 0 0 0
v 1 0 0 1.0
v 1 1 0 0.5 0.5 0.5
v 0 1 0
vt 0 0
vt 1 0 0
vt 1 1
vn 0 0 1
s off
g skin nose
usemtl pink
f 1/1/1 2/2/1 3/3/1 4
g tooth
f -4 -3// \\
  -2//-1
"""


def read(tmp_path: Path, text: str | bytes) -> RawMesh:
    path = tmp_path / "face.obj"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_obj(path)


def test_polygons_groups_materials_and_negative_indices_are_read(tmp_path: Path) -> None:
    (tmp_path / "square.mtl").write_text("newmtl pink\nKd 1 0 0\nmap_Kd missing.png\nmap_Kd skin.png\n")
    (tmp_path / "skin.png").touch()
    raw = read(tmp_path, EXAMPLE)
    assert raw.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert raw.uvs.tolist() == [[0, 0], [1, 0], [1, 1]]
    assert raw.corners[..., 0].tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    assert raw.corners[..., 1].tolist() == [[0, 1, 2], [0, 2, -1], [-1, -1, -1]]
    assert {name: rows.tolist() for name, rows in raw.groups.items()} == {"skin": [0, 1], "nose": [0, 1], "tooth": [2]}
    assert raw.texture == tmp_path / "skin.png"


def test_a_missing_material_or_texture_is_ignored(tmp_path: Path) -> None:
    assert read(tmp_path, EXAMPLE).texture is None
    (tmp_path / "square.mtl").write_bytes(b"map_Kd \xff\x00/../../x\n" * 3)
    assert read(tmp_path, EXAMPLE).texture is None


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", None, "expected an OBJ mesh with vertices"),
        (TRIANGLE, None, "expected an OBJ mesh with vertices"),
        ("hello", None, "skipped 1 lines with an unknown keyword (first in line 1)"),
        (TRIANGLE + "f 1 2", None, "skipped 1 faces with fewer than three corners (first in line 4)"),
        (TRIANGLE + "f 1 2 4", None, "expected an OBJ mesh with vertices"),
        (TRIANGLE + "f 0 1 2", None, "expected an OBJ mesh with vertices"),
        (TRIANGLE + "f -4 1 2", None, "expected an OBJ mesh with vertices"),
        (TRIANGLE + "f 1.5 2 3", None, "skipped 1 faces that cannot be read (first in line 4)"),
        ("x\n" * 100_001, 100_001, "expected an OBJ file, found over 100,000 lines with an unknown keyword"),
        ("v 0 0 0 " + " " * 70_000, None, "skipped 1 lines of over 64 KB (first in line 1)"),
    ],
)
def test_a_file_in_which_nothing_can_be_drawn_is_refused(
    tmp_path: Path, text: str, line: int | None, expected: str
) -> None:
    with pytest.raises(FileFormatError) as caught:
        read(tmp_path, text)
    assert caught.value.line == line
    assert expected in str(caught.value)
    assert "face.obj" in str(caught.value)


WORDS = st.sampled_from("v;vt;vn;f;g;o;usemtl;mtllib;#;\\;0;1;-1;2/1;1//2;3.5;1e9;nan;\n".split(";"))


@pytest.mark.slow
@given(st.one_of(st.binary(max_size=300), st.lists(WORDS, max_size=80).map(lambda words: " ".join(words).encode())))
def test_any_bytes_give_a_mesh_or_file_format_error(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.obj"
    path.write_bytes(data)
    try:
        raw = read_obj(path)
    except FileFormatError:
        return
    assert np.isfinite(raw.positions).all()
    assert 0 <= raw.corners[..., 0].min() <= raw.corners[..., 0].max() < len(raw.positions)
    assert raw.corners[..., 1].max() < len(raw.uvs)


@pytest.mark.slow
@given(st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), min_size=3, max_size=30))
def test_vertices_keep_the_order_of_the_file(
    tmp_path_factory: pytest.TempPathFactory, vertices: list[tuple[float, float, float]]
) -> None:
    path = tmp_path_factory.getbasetemp() / "order.obj"
    text = io.StringIO()
    for x, y, z in vertices:
        text.write(f"v {x!r} {y!r} {z!r}\n")
    path.write_text(text.getvalue() + "f 1 2 3\n")
    assert read_obj(path).positions.tolist() == [list(vertex) for vertex in vertices]
