from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.mesh.mesh import load_mesh

KINDS = ["ply", "glb", "stl"]


def box() -> trimesh.Trimesh:
    return trimesh.creation.box()


@pytest.mark.parametrize("kind", KINDS)
def test_a_box_comes_back(tmp_path: Path, kind: str) -> None:
    box().export(tmp_path / f"box.{kind}")
    mesh = load_mesh(tmp_path / f"box.{kind}")
    assert len(mesh.triangles) == 12
    corners = mesh.vertices[mesh.triangles.ravel()]
    assert np.unique(np.abs(corners)).tolist() == [0.5]
    area = np.linalg.norm(np.cross(corners[1::3] - corners[::3], corners[2::3] - corners[::3]), axis=1).sum()
    assert area / 2 == pytest.approx(6)


@pytest.mark.parametrize("kind", ["ply", "glb"])
def test_vertices_keep_their_order(tmp_path: Path, kind: str) -> None:
    box().export(tmp_path / f"box.{kind}")
    assert load_mesh(tmp_path / f"box.{kind}").vertices == pytest.approx(box().vertices)


def test_parts_of_a_scene_become_groups_where_they_stand(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(box(), geom_name="left", transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    scene.add_geometry(box(), geom_name="right")
    scene.export(tmp_path / "two.glb")
    mesh = load_mesh(tmp_path / "two.glb")
    assert len(mesh.groups) == 2
    assert sorted(len(rows) for rows in mesh.groups.values()) == [12, 12]
    assert mesh.vertices[:, 0].max() == pytest.approx(3.5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("data", [b"", b"hello", b"ply\n", b"glTF\x02\x00\x00\x00", b"solid x", b"\x00" * 200])
def test_what_is_no_mesh_is_said_to_be_none(tmp_path: Path, kind: str, data: bytes) -> None:
    path = tmp_path / f"bad.{kind}"
    path.write_bytes(data)
    with pytest.raises(FileFormatError, match="expected a"):
        load_mesh(path)


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_damaged_files_give_a_mesh_or_the_one_error(
    tmp_path_factory: pytest.TempPathFactory, kind: str, data: st.DataObject
) -> None:
    whole = bytearray(box().export(file_type=kind))
    for _ in range(data.draw(st.integers(0, 6))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / f"any.{kind}"
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole)))])
    try:
        mesh = load_mesh(path)
    except FileFormatError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert 0 <= mesh.triangles.min() <= mesh.triangles.max() < len(mesh.vertices)
