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
def test_a_box_is_read(tmp_path: Path, kind: str) -> None:
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


def test_parts_of_a_scene_become_groups_with_their_transforms_applied(tmp_path: Path) -> None:
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
def test_files_that_are_no_mesh_raise_file_format_error(tmp_path: Path, kind: str, data: bytes) -> None:
    path = tmp_path / f"bad.{kind}"
    path.write_bytes(data)
    with pytest.raises(FileFormatError, match="expected a"):
        load_mesh(path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_damaged_files_give_a_mesh_or_file_format_error(
    tmp_path_factory: pytest.TempPathFactory, kind: str, data: st.DataObject
) -> None:
    exported = box().export(file_type=kind)
    assert isinstance(exported, bytes)
    content = bytearray(exported)
    for _ in range(data.draw(st.integers(0, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / f"any.{kind}"
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        mesh = load_mesh(path)
    except FileFormatError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert 0 <= mesh.triangles.min() <= mesh.triangles.max() < len(mesh.vertices)
