from pathlib import Path

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.mesh.mesh import Mesh, load_mesh

CUBE_CORNER = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
v 9 9 9
vt 0 0
vt 1 0
vt 0 1
g floor
f 1/1 2/2 3/3
g wall
f 1/1 3/2 4/3
f 1/1 4/3 2/2
"""


def read(tmp_path: Path, text: str) -> Mesh:
    (tmp_path / "face.obj").write_text(text)
    return load_mesh(tmp_path / "face.obj")


def test_a_position_has_a_render_vertex_for_each_of_its_texture_coordinates(tmp_path: Path) -> None:
    mesh = read(tmp_path, CUBE_CORNER)
    assert mesh.vertices.shape == (5, 3)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 1]]
    assert len(mesh.render_vertices) == 5  # vertex 3 has two texture coordinates, the unused one none
    assert mesh.render_vertices[mesh.render_triangles].tolist() == mesh.triangles.tolist()
    assert mesh.uvs[mesh.render_triangles[1]].tolist() == [[0, 0], [1, 0], [0, 1]]
    assert mesh.triangles.dtype == mesh.render_triangles.dtype == mesh.render_vertices.dtype == np.int32


def test_group_vertices_are_sorted_and_unique(tmp_path: Path) -> None:
    mesh = read(tmp_path, CUBE_CORNER)
    assert mesh.group_vertices("floor").tolist() == [0, 1, 2]
    assert mesh.group_vertices("floor", "wall").tolist() == [0, 1, 2, 3]
    assert mesh.group_vertices("roof").tolist() == []


def test_without_texture_coordinates_there_is_one_render_vertex_per_vertex(tmp_path: Path) -> None:
    mesh = read(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert mesh.render_vertices.tolist() == [0, 1, 2]
    assert mesh.uvs.tolist() == [[0, 0]] * 3


@pytest.mark.parametrize("name", ["face.fbx", "face", "face.ppc"])
def test_other_file_types_are_rejected(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileFormatError, match=r"expected a mesh file \(\.obj, \.ply, \.glb, \.vrm, \.gltf, \.stl\)"):
        load_mesh(tmp_path / name)


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="expected a file; check the name"):
        load_mesh(tmp_path / "face.obj")
