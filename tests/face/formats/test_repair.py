import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.formats.repair import repair
from conf.face.mesh.mesh import Mesh, load_mesh

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
BOX = trimesh.creation.box()


def read(tmp_path: Path, data: bytes, suffix: str) -> Mesh:
    (tmp_path / f"face.{suffix}").write_bytes(data)
    return load_mesh(tmp_path / f"face.{suffix}")


def mixed_ply(order: str, *, more: bool = False) -> bytes:
    """Return a square as a quad, a triangle and a pentagon; `more` adds colours of faces and edges after them."""
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = f"ply\r\nformat {name} 1.0\r\ncomment made by hand\r\nelement vertex 5\r\n"
    header += "".join(f"property double {axis}\r\n" for axis in "xyz")
    header += "element face 3\r\nproperty list uchar int vertex_indices\r\n"
    header += "property uchar red\r\nelement edge 1\r\nproperty int a\r\n" if more else ""
    points = np.concatenate([SQUARE, [[0.5, 1.5, 0]]]).astype(f"{order}f8").tobytes()
    faces = [(0, 1, 2, 3), (0, 1, 2), (0, 1, 2, 4, 3)]
    rows = (struct.pack(f"{order}B{len(f)}i", len(f), *f) + (b"\x07" if more else b"") for f in faces)
    return (header + "end_header\r\n").encode() + points + b"".join(rows) + (b"\1\0\0\0" if more else b"")


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("more", [False, True])
def test_a_binary_ply_of_triangles_and_quads_is_read(tmp_path: Path, order: str, more: bool) -> None:
    mesh = read(tmp_path, mixed_ply(order, more=more), "ply")
    triangles = [{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 2}, {0, 2, 4}, {0, 3, 4}]
    assert [set(triangle) for triangle in mesh.triangles.tolist()] == triangles
    assert mesh.vertices[:4].tolist() == SQUARE.tolist()


@pytest.mark.parametrize("kind", ["ply", "glb", "stl"])
def test_a_sound_file_is_not_changed(kind: str) -> None:
    data, notes = BOX.export(file_type=kind), list[str]()
    assert repair(kind, data, notes) == data and notes == []


@pytest.mark.parametrize("kind", ["ascii", "binary"])
def test_each_encoding_of_ply_is_read(tmp_path: Path, kind: str) -> None:
    mesh = read(tmp_path, BOX.export(file_type="ply", encoding=kind), "ply")
    assert mesh.triangles.tolist() == BOX.faces.tolist()


def test_bytes_after_the_triangles_of_an_stl_are_ignored(tmp_path: Path) -> None:
    mesh = read(tmp_path, BOX.export(file_type="stl") + b"made by a scanner", "stl")
    assert len(mesh.triangles) == 12 and mesh.notes == ()


def test_an_stl_that_ends_early_keeps_its_whole_triangles(tmp_path: Path) -> None:
    mesh = read(tmp_path, BOX.export(file_type="stl")[:-70], "stl")
    assert len(mesh.triangles) == 10 and mesh.notes[0] == "the file ends after 10 of 12 triangles"
    with pytest.raises(FileFormatError, match="expected a STL mesh, found something else"):
        read(tmp_path, BOX.export(file_type="stl")[:100], "stl")


@pytest.mark.parametrize("change", [lambda text: text, str.upper, lambda text: text.replace("\n", "\r\n")])
def test_an_ascii_stl_is_read(tmp_path: Path, change: object) -> None:
    assert callable(change)
    text = BOX.export(file_type="stl_ascii")
    assert len(read(tmp_path, change(text).encode(), "stl").triangles) == 12


@pytest.mark.slow
@given(data=st.data())
def test_a_damaged_ply_is_left_to_the_reader(data: st.DataObject) -> None:
    content = bytearray(mixed_ply("<"))
    for _ in range(data.draw(st.integers(1, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    assert isinstance(repair("ply", bytes(content[: data.draw(st.integers(0, len(content)))]), []), bytes)
