from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.fitting.default_texture import (
    COLOUR_UVS,
    EYE_ARC,
    EYE_UV,
    EYE_UV_RADII,
    TEXTURE_FILE,
    apply_default_texture,
)
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh, load_mesh


@pytest.fixture(scope="module")
def head() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.fixture(scope="module")
def textured(head: Mesh) -> Mesh:
    return apply_default_texture(head, default_points(), default_joints().eyes)


def uvs_of(mesh: Mesh, group: str) -> np.ndarray:
    return mesh.uvs[np.unique(mesh.render_triangles[mesh.groups[group]])]


def test_the_surface_is_unchanged(head: Mesh, textured: Mesh) -> None:
    assert textured.vertices is head.vertices
    assert textured.render_vertices[textured.render_triangles].tolist() == head.triangles.tolist()


@pytest.mark.parametrize(
    ("group", "colour"),
    [("skin", "skin"), ("hair", "skin"), ("teeth_upper", "teeth"), ("tongue", "tongue"), ("mouth", "mouth")],
)
def test_each_part_has_its_colour(textured: Mesh, group: str, colour: str) -> None:
    assert np.unique(uvs_of(textured, group), axis=0).tolist() == [list(COLOUR_UVS[colour])]


def test_the_iris_is_centred_on_the_pupil_at_its_true_size(head: Mesh, textured: Mesh) -> None:
    rows = np.unique(textured.render_triangles[textured.groups["eye_l"]])
    vertices = textured.vertices[textured.render_vertices[rows]]
    pupil = default_points()[16]
    off = (textured.uvs[rows] - EYE_UV) / EYE_UV_RADII
    nearest = np.linalg.norm(vertices - pupil, axis=1).argmin()
    assert off[nearest] == pytest.approx([0, 0], abs=0.03)
    near = np.linalg.norm((vertices - pupil)[:, :2], axis=1) < 0.6
    assert np.hypot(*off[near].T) * EYE_ARC == pytest.approx(np.hypot(*(vertices - pupil)[near, :2].T), abs=0.06)
    right = vertices[:, 0] > pupil[0] + 0.2
    assert (off[right, 0] > 0).all()  # the subject's left is the image's right


def test_the_texture_has_a_dark_pupil_and_a_light_sclera() -> None:
    with Image.open(TEXTURE_FILE) as image:
        colours = np.asarray(image.convert("RGB"), dtype=float)
    height, width, _ = colours.shape

    def at(u: float, v: float) -> np.ndarray:
        return np.asarray(colours[int((1 - v) * height), int(u * width)])

    assert at(*EYE_UV).mean() < 30
    assert at(*(EYE_UV + EYE_UV_RADII * [0.5, 0])).mean() > 180
    assert at(*COLOUR_UVS["skin"])[0] > at(*COLOUR_UVS["mouth"])[0] + 50


@pytest.mark.slow
def test_materials_with_an_image_or_of_the_skin_are_kept_and_plain_eyes_replaced(head: Mesh) -> None:
    materials = (MeshMaterial(colour=(0.3, 0.2, 0.1)), MeshMaterial(image=np.zeros((1, 1, 4), np.uint8)))
    numbers = np.zeros(len(head.triangles), np.int32)
    numbers[head.groups["teeth_upper"]] = 1
    mesh = replace(head, texture=None, materials=materials, triangle_materials=numbers)
    textured = apply_default_texture(mesh, default_points(), default_joints().eyes)
    numbers = textured.materials_of_triangles()
    found = {name: np.unique(numbers[rows]).tolist() for name, rows in textured.groups.items()}
    assert found["skin"] == found["hair"] == [0] and found["teeth_upper"] == [1] and found["eye_l"] == [-1]
    assert textured.render_vertices[textured.render_triangles].tolist() == head.triangles.tolist()
    rows = head.groups["teeth_upper"]
    np.testing.assert_array_equal(textured.uvs[textured.render_triangles[rows]], head.uvs[head.render_triangles[rows]])
    assert np.ptp(uvs_of(textured, "eye_l"), axis=0).min() > 0.3
