from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.render.materials import TRANSLUCENT
from conf.render.textures import MeshImages, linear_from_srgb, read_image, separate_transparent, with_transparent_parts
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


@pytest.mark.slow
def test_a_part_is_transparent_by_its_alpha_and_not_by_its_name(window: OffscreenWindow, face: FaceModel) -> None:
    """The hair, renamed, is drawn as before if its image is transparent; the skin is drawn opaque."""
    clear = MeshMaterial(image=plain((0, 0, 0, 0)))
    renamed = {"hair": "polySurface7"} | {name: name for name in face.mesh.groups if name != "hair"}
    mesh = replace(face.mesh, groups={renamed[name]: rows for name, rows in face.mesh.groups.items()})
    coverage = np.concatenate([np.zeros((1, 2, 4), np.uint8), np.full((1, 2, 4), 255, np.uint8)])
    mesh = replace(mesh, uvs=np.full((len(mesh.render_vertices), 2), 0.75))
    mesh = with_materials(mesh, replace(clear, image=coverage), of={"polySurface7": 0})
    separate = separate_transparent(mesh, MeshImages(mesh))
    assert separate.groups[TRANSLUCENT].tolist() == mesh.groups["polySurface7"].tolist()
    bald = replace(face.mesh, groups={name: rows for name, rows in face.mesh.groups.items() if name != "hair"})
    bald = replace(bald, triangles=np.delete(bald.triangles, face.mesh.groups["hair"], 0),
                   render_triangles=np.delete(bald.render_triangles, face.mesh.groups["hair"], 0))  # fmt: skip
    hairless = rendered(window, replace(face, mesh=bald), pose()).astype(int)
    np.testing.assert_allclose(rendered(window, replace(face, mesh=mesh), pose()), hairless, atol=3)


@pytest.mark.parametrize(
    ("material", "blended"),
    [
        (MeshMaterial(alpha=0.5), True),
        (MeshMaterial(alpha=0.0), False),  # nothing would be visible
        (MeshMaterial(image=plain((9, 9, 9, 120))), False),  # gloss
        (MeshMaterial(image=plain((9, 9, 9, 120)), has_alpha=True), True),
        (MeshMaterial(image=plain((9, 9, 9, 0))), False),  # an alpha channel that was never filled
        (MeshMaterial(image=plain((9, 9, 9, 0)), has_alpha=False), False),
        (MeshMaterial(image=plain((9, 9, 9, 255))), False),
    ],
)
def test_which_alpha_makes_a_part_transparent(face: FaceModel, material: MeshMaterial, blended: bool) -> None:
    every = {name: 0 for name in face.mesh.groups}
    mesh = with_materials(replace(face.mesh, groups={"a": np.arange(len(face.mesh.triangles))}), material, of={"a": 0})
    assert every and (TRANSLUCENT in separate_transparent(mesh, MeshImages(mesh)).groups) is blended


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


@pytest.mark.slow
def test_the_hair_of_the_default_head_is_found_without_its_names() -> None:
    head = load_mesh(DEFAULT_HEAD)
    mesh = replace(head, groups={f"{name}_Mesh.001": rows for name, rows in head.groups.items()})
    found = separate_transparent(mesh, MeshImages(mesh)).groups[TRANSLUCENT]
    np.testing.assert_array_equal(found, np.union1d(head.groups["hair"], head.groups["lashes"]))
    assert with_transparent_parts(head) is head, "its names say so"
