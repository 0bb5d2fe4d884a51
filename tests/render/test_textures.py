from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh
from conf.render.textures import MeshImages, linear_from_srgb, read_image
from conf.render.window.offscreen import OffscreenWindow
from tests.render.test_face_renderer import pose, rendered


def with_materials(mesh: Mesh, *materials: MeshMaterial, of: dict[str, int]) -> Mesh:
    numbers = np.full(len(mesh.triangles), -1, np.int32)
    for group, number in of.items():
        numbers[mesh.groups[group]] = number
    return replace(mesh, materials=materials, triangle_materials=numbers)


def plain(rgba: tuple[int, int, int, int]) -> np.ndarray:
    return np.full((2, 2, 4), rgba, np.uint8)


@pytest.mark.slow
def test_each_part_is_drawn_with_the_colour_of_its_material(window: OffscreenWindow, face: FaceModel) -> None:
    red = MeshMaterial(colour=(1.0, 0.0, 0.0))
    blue = MeshMaterial(image=plain((0, 0, 255, 255)))
    for material, channel in ((red, 2), (blue, 0)):  # of BGR
        mesh = with_materials(face.mesh, MeshMaterial(), material, of={"skin": 1, "hair": 0})
        pixels = rendered(window, replace(face, mesh=mesh), pose()).astype(int)
        cheek = pixels[125:135, 130:140].mean(axis=(0, 1))
        assert cheek[channel] > 3 * max(cheek[1], cheek[2 - channel], 1)


@pytest.mark.slow
def test_vertex_colours_are_drawn(window: OffscreenWindow, face: FaceModel) -> None:
    colours = np.tile(np.array([0.0, 1.0, 0.0], np.float32), (len(face.mesh.vertices), 1))
    mesh = replace(with_materials(face.mesh, MeshMaterial(), of={"skin": 0}), vertex_colours=colours)
    cheek = rendered(window, replace(face, mesh=mesh), pose())[125:135, 130:140].astype(int).mean(axis=(0, 1))
    assert cheek[1] > 3 * max(cheek[0], cheek[2], 1)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_images_of_any_depth_and_a_mask_are_read(tmp_path: Path, dtype: type, channels: int) -> None:
    top = np.iinfo(dtype).max
    cv2.imwrite(str(tmp_path / "a.png"), np.full((4, 6, channels), top // 5, dtype))
    cv2.imwrite(str(tmp_path / "mask.png"), np.full((2, 3), 102, np.uint8))
    found = read_image(MeshMaterial(image=tmp_path / "a.png", alpha_image=tmp_path / "mask.png"))
    assert found.shape == (4, 6, 4) and found[0, 0].tolist() == [51, 51, 51, 102]


def test_srgb_becomes_linear() -> None:
    assert linear_from_srgb(np.array([0.0, 0.02, 0.5, 1.0])) == pytest.approx([0, 0.001548, 0.21404, 1], abs=1e-5)


def test_images_are_read_once_also_ahead(face: FaceModel, tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), np.full((2, 3, 3), 7, np.uint8))
    materials = MeshMaterial(image=path), MeshMaterial(image=path, colour=(1.0, 0.0, 0.0)), MeshMaterial()
    images = MeshImages(with_materials(face.mesh, *materials, of=dict(zip(face.mesh.groups, range(3), strict=False))))
    images.read_ahead()
    first = images.pixels(0)
    path.unlink()
    assert first is not None and first.shape == (2, 3, 4) and images.pixels(1) is first and images.pixels(2) is None


def test_a_file_that_is_no_image_is_said_when_it_is_needed(face: FaceModel, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"no image")
    images = MeshImages(with_materials(face.mesh, MeshMaterial(image=tmp_path / "a.png"), of={"skin": 0}))
    images.read_ahead()
    with pytest.raises(FileFormatError, match=r"a\.png: expected a PNG, JPEG or WebP image"):
        images.pixels(0)
