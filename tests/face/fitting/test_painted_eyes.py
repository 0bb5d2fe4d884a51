"""Eyes that are painted on a sheet are kept on the eyeballs that are put behind it."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.fitting.custom_face import prepare_face
from conf.face.fitting.painted_eyes import image_between_lids, keep_painted_eyes
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh
from tests.support.sheet_face import SheetFace

SKIN, WHITE, IRIS = (205, 150, 125, 255), (235, 230, 225, 255), (60, 45, 30, 255)


def skin_image(points: NDArray[np.float64], *, with_eyes: bool) -> NDArray[np.uint8]:
    """Return an image of skin with 10 px a cm, the origin in its lower left corner, and eyes painted on it."""
    image = np.empty((1000, 1000, 4), np.uint8)
    image[:] = SKIN
    columns, rows = np.meshgrid(np.arange(1000), np.arange(999, -1, -1))
    for pupil in points[PUPILS] if with_eyes else ():
        distance = np.hypot((columns - pupil[0] * 10 + 500) % 1000 - 500, (rows - pupil[1] * 10 + 500) % 1000 - 500)
        image[distance < 12] = WHITE
        image[distance < 5] = IRIS
    return image


MATERIALS = (MeshMaterial(colour=(0.8, 0.6, 0.5)), MeshMaterial(image=np.zeros((2, 2, 4), np.uint8)))


def painted(face: SheetFace, number: int) -> Mesh:
    """Return the sheet with one material; its texture coordinates are its positions, over 100."""
    mesh = face.mesh
    numbers = np.full(len(mesh.triangles), number, np.int32)
    uvs = mesh.vertices[mesh.render_vertices, :2] / 100
    return replace(mesh, uvs=uvs, materials=MATERIALS, triangle_materials=numbers)


def test_the_material_between_the_lids_counts_if_it_has_an_image(shut_face: SheetFace) -> None:
    assert image_between_lids(painted(shut_face, 1), shut_face.points, "l") == 1
    assert image_between_lids(painted(shut_face, 0), shut_face.points, "l") == -1
    assert image_between_lids(shut_face.mesh, shut_face.points, "r") == -1
    beside = shut_face.points + np.array([100.0, 0.0, 0.0])
    assert image_between_lids(painted(shut_face, 1), beside, "l") == -1


@pytest.mark.slow
def test_eyeballs_show_what_the_skin_showed(shut_face: SheetFace) -> None:
    image = MeshMaterial(image=skin_image(shut_face.points, with_eyes=True))
    face = prepare_face(replace(painted(shut_face, 1), materials=(MATERIALS[0], image)), shut_face.points)
    assert "no opening between the lids: cut open" in face.remarks and "no eyeballs: put in" in face.remarks
    mesh, to_file = face.mesh, face.file_to_model.inverse_apply
    for group, side in (("eye_l", "l"), ("eye_r", "r")):
        rows = mesh.groups[group]
        assert (mesh.materials_of_triangles()[rows] == 1).all()
        rendered = np.unique(mesh.render_triangles[rows])
        positions, uvs = mesh.vertices[mesh.render_vertices[rendered]], mesh.uvs[rendered]
        pupil, corner = (face.points[CONTROL_POINT_INDEX[f"{name}_{side}"]] for name in ("pupil", "eye_outer_corner"))
        distance = np.linalg.norm(positions[:, :2] - pupil[:2], axis=1)
        distance = np.minimum(distance, 0.75 * abs(corner[0] - pupil[0]))
        expected = pupil + np.sign(corner[0] - pupil[0]) * distance[:, None] * [1.0, 0.0, 0.0]
        np.testing.assert_allclose(uvs, to_file(expected)[:, :2] / 100, atol=1e-6)
        assert np.ptp(uvs[:, 0]) > 0.005
    assert len(face.rig.eyes) == len(PUPILS)


@pytest.mark.slow
def test_eyes_of_a_plain_skin_get_the_default_texture(shut_face: SheetFace) -> None:
    face = prepare_face(painted(shut_face, 0), shut_face.points)
    rows = np.concatenate([face.mesh.groups[name] for name in ("eye_l", "eye_r")])
    assert (face.mesh.materials_of_triangles()[rows] == -1).all()


@pytest.mark.slow
@pytest.mark.parametrize("is_file", [True, False])
def test_closed_eyes_in_a_texture_get_the_default_texture(shut_face: SheetFace, tmp_path: Path, is_file: bool) -> None:
    image = skin_image(shut_face.points, with_eyes=False)
    cv2.imwrite(str(tmp_path / "skin.png"), image[..., [2, 1, 0, 3]])
    material = MeshMaterial(image=tmp_path / "skin.png" if is_file else image)
    face = prepare_face(replace(painted(shut_face, 1), materials=(MATERIALS[0], material)), shut_face.points)
    rows = np.concatenate([face.mesh.groups[name] for name in ("eye_l", "eye_r")])
    assert (face.mesh.materials_of_triangles()[rows] == -1).all()
    assert "no eyeballs: put in" in face.remarks


def test_a_mesh_without_materials_is_returned_as_it_is(shut_face: SheetFace) -> None:
    assert keep_painted_eyes(shut_face.mesh, shut_face.mesh, shut_face.points, ()) is shut_face.mesh
