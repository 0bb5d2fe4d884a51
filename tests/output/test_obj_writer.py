import os
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import cv2
import numpy as np
import pytest

from conf.errors import ConfError
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.output.obj_writer import write_obj
from conf.render.textures import read_image


@pytest.fixture(scope="module")
def head() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.mark.slow
def test_a_written_mesh_is_read_back_unchanged(tmp_path: Path, head: Mesh) -> None:
    write_obj(tmp_path / "a.obj", head, head.vertices)
    mesh = load_mesh(tmp_path / "a.obj")
    np.testing.assert_allclose(mesh.vertices, head.vertices, atol=1e-5)
    np.testing.assert_array_equal(mesh.triangles, head.triangles)
    for name, triangles in head.groups.items():
        np.testing.assert_array_equal(mesh.groups[name], triangles)
    assert mesh.texture == tmp_path / "a-texture.png", "WebP is converted to PNG"
    shade, again = (cv2.imread(str(m.texture), cv2.IMREAD_UNCHANGED) for m in (head, mesh))
    assert shade is not None and again is not None and np.array_equal(shade, again)
    text, library = ((tmp_path / name).read_text() for name in ("a.obj", "a.mtl"))
    assert text.index("usemtl face") < text.index("g hair\nusemtl hair") and "map_d a-texture.png" in library


@pytest.mark.slow
def test_a_portable_texture_is_copied_and_a_mesh_without_texture_gets_no_material(tmp_path: Path, head: Mesh) -> None:
    cv2.imwrite(str(tmp_path / "skin.jpg"), np.zeros((4, 4, 3), np.uint8))
    textured = replace(head, texture=tmp_path / "skin.jpg")
    write_obj(tmp_path / "b.obj", textured, textured.vertices)
    assert (tmp_path / "b-texture.jpg").read_bytes() == (tmp_path / "skin.jpg").read_bytes()
    write_obj(tmp_path / "b.obj", load_mesh(tmp_path / "b.obj"), textured.vertices)
    assert load_mesh(tmp_path / "b.obj").texture == tmp_path / "b-texture.jpg", "written over itself"
    write_obj(tmp_path / "c.obj", replace(head, texture=None), head.vertices)
    assert not (tmp_path / "c.mtl").exists() and "usemtl" not in (tmp_path / "c.obj").read_text()


def small_mesh(folder: Path) -> Mesh:
    """Return a triangle with a texture."""
    folder.mkdir(exist_ok=True)
    (folder / "skin.webp").write_bytes(cv2.imencode(".webp", np.full((4, 4, 3), 90, np.uint8))[1].tobytes())
    (folder / "a.mtl").write_text("newmtl a\nmap_Kd skin.webp\n")
    (folder / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n"
    )
    return load_mesh(folder / "a.obj")


def test_any_folder_and_file_name_can_be_written(tmp_path: Path) -> None:
    mesh = small_mesh(tmp_path / os.fsdecode(b"\xefn"))
    path = tmp_path / os.fsdecode(b"na\xefve.obj")
    write_obj(path, mesh, mesh.vertices)
    found = load_mesh(path)
    assert found.texture == tmp_path / os.fsdecode(b"na\xefve-texture.png") and found.notes == ()


def test_an_interrupted_write_keeps_the_old_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = small_mesh(tmp_path / "in")
    write_obj(tmp_path / "a.obj", mesh, mesh.vertices)
    before = {path: path.read_bytes() for path in tmp_path.glob("a*")}

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("conf.output.obj_writer.group_triangles", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_obj(tmp_path / "a.obj", mesh, 2 * mesh.vertices)
    assert {path: path.read_bytes() for path in before} == before


@pytest.mark.slow
def test_a_missing_folder_is_named(tmp_path: Path, head: Mesh) -> None:
    with pytest.raises(ConfError, match=r"a\.obj cannot be written \(No such file or directory\)"):
        write_obj(tmp_path / "none" / "a.obj", head, head.vertices)


@pytest.mark.slow
def test_materials_and_vertex_colours_are_written_and_read_back(tmp_path: Path, head: Mesh) -> None:
    image = np.random.default_rng(1).integers(0, 255, (4, 4, 4), dtype=np.uint8)
    materials = (MeshMaterial(colour=(0.1, 0.2, 0.3), alpha=0.5), MeshMaterial(image=image, has_alpha=True))
    numbers = (np.arange(len(head.triangles)) >= len(head.groups["skin"])).astype(np.int32)
    colours = np.random.default_rng(2).random(head.vertices.shape, np.float32)
    mesh = replace(head, texture=None, materials=materials, triangle_materials=numbers, vertex_colours=colours)
    write_obj(tmp_path / "d.obj", mesh, mesh.vertices)
    found = load_mesh(tmp_path / "d.obj")
    assert found.vertex_colours == pytest.approx(colours, abs=1e-4)
    np.testing.assert_array_equal(found.materials_of_triangles(), numbers)
    assert found.materials[0].colour == (0.1, 0.2, 0.3) and found.materials[0].alpha == 0.5
    np.testing.assert_array_equal(read_image(found.materials[1]), image[::-1])


@pytest.mark.slow
def test_a_failed_write_keeps_the_old_files_and_leaves_no_others(
    tmp_path: Path, head: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a.obj", "a.mtl", "a-texture.png"):
        (tmp_path / name).write_bytes(b"old")
    monkeypatch.setattr(Path, "replace", Mock(side_effect=OSError(28, "No space left on device")))
    with pytest.raises(ConfError, match=r"a\.obj cannot be written \(No space left on device\)"):
        write_obj(tmp_path / "a.obj", head, head.vertices)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        "a.obj": b"old", "a.mtl": b"old", "a-texture.png": b"old",
    }  # fmt: skip
