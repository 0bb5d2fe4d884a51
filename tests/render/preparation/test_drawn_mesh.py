from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.disk_cache import cache_folder
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.winding import orient_outwards
from conf.render.materials import TRANSLUCENT
from conf.render.preparation.drawn_mesh import drawn_mesh
from conf.render.preparation.transparency import separate_transparent
from conf.render.preparation.vertex_cache import optimise_vertex_cache
from conf.render.textures import MeshImages
from tests.face.test_prepared_face import assert_same
from tests.render.test_textures import with_materials


@pytest.fixture(autouse=True)
def _empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def drawn(mesh: Mesh) -> Mesh:
    return drawn_mesh(mesh, MeshImages(mesh))


@pytest.mark.slow
def test_a_mesh_is_prepared_once(face: FaceModel, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = replace(
        face.mesh, triangles=face.mesh.triangles[:, ::-1], render_triangles=face.mesh.render_triangles[:, ::-1]
    )
    expected = optimise_vertex_cache(orient_outwards(separate_transparent(mesh, MeshImages(mesh))))
    assert_same(drawn(mesh), expected)
    monkeypatch.setattr("conf.render.preparation.vertex_cache.optimise_vertex_cache", None)  # a second call would raise
    assert_same(drawn(mesh), expected)


@pytest.mark.slow
def test_another_image_is_another_mesh(face: FaceModel, tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    one = replace(face.mesh, groups={"a": np.arange(len(face.mesh.triangles))})
    mesh = with_materials(one, MeshMaterial(image=path, has_alpha=True), of={"a": 0})
    for alpha in (255, 90):
        cv2.imwrite(str(path), np.full((2, 2 + alpha // 200, 4), alpha, np.uint8))
        found = drawn(mesh)
        assert (TRANSLUCENT in found.groups) is (alpha == 90)
        assert found.materials == mesh.materials


@pytest.mark.slow
def test_a_large_mesh_is_not_kept(face: FaceModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.render.preparation.drawn_mesh._MAX_TRIANGLES", 10)
    drawn(face.mesh)
    assert not cache_folder("meshes").exists()
