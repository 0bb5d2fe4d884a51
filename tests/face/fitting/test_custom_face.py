from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import DEFAULT_HEAD, EYE_MIDPOINT, default_joints, default_points
from conf.face.fitting.custom_face import PreparedFace, find_file_to_model, prepare_face
from conf.face.fitting.default_texture import TEXTURE_FILE
from conf.face.mesh.mesh import Mesh, load_mesh
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def bare() -> Mesh:
    """The shipped head as somebody else might have it: no groups, no picture, lying on its back, in millimetres."""
    head = load_mesh(DEFAULT_HEAD)
    everything = {"default": np.arange(len(head.triangles))}
    return replace(head, vertices=head.vertices @ turn().T * 10, groups=everything, texture=None)


@pytest.fixture(scope="module")
def own(bare: Mesh) -> PreparedFace:
    return prepare_face(bare, default_points() @ turn().T * 10)


def turn() -> np.ndarray:
    return Rotation.from_rotvec([-np.pi / 2, 0, 0]).as_matrix()


def test_it_comes_to_model_centimetres_and_back(bare: Mesh, own: PreparedFace) -> None:
    np.testing.assert_allclose(own.points, default_points(), atol=0.02)
    np.testing.assert_allclose(own.file_to_model.inverse_apply(own.mesh.vertices), bare.vertices, atol=1e-9)


def test_its_eyes_turn_and_its_lower_teeth_have_a_hinge(own: PreparedFace) -> None:
    assert [eye.pupil for eye in own.rig.eyes] == PUPILS
    jaw, hinge = own.rig.jaw, default_joints().hinge
    assert jaw is not None and hinge is not None
    assert jaw.centre == pytest.approx(hinge[0], abs=0.05)
    assert jaw.vertices.tolist() == own.mesh.group_vertices("teeth_lower", "tongue").tolist()
    assert not jaw.point_weights.any()
    assert set(own.mesh.group_vertices("teeth_upper")) <= set(own.rig.rigid)


def test_one_without_a_picture_is_painted_and_one_with_keeps_its_own(bare: Mesh, own: PreparedFace) -> None:
    assert own.mesh.texture == TEXTURE_FILE
    with_picture = replace(bare, texture=DEFAULT_HEAD.with_name("skin.webp"))
    kept = prepare_face(with_picture, default_points() @ turn().T * 10).mesh
    assert kept.texture == with_picture.texture
    assert kept.uvs is with_picture.uvs
    assert {"eye_l", "mouth", "tongue"} <= set(kept.groups)


def test_a_face_that_is_about_upright_is_not_turned() -> None:
    tilt = Rotation.from_rotvec([0.2, 0, 0]).as_matrix()
    placement = find_file_to_model(default_points() @ tilt.T * 3)
    assert placement.rotation.tolist() == np.eye(3).tolist()
    pupils = placement.apply(default_points() @ tilt.T * 3)[PUPILS]
    assert pupils.mean(axis=0) == pytest.approx(EYE_MIDPOINT)
    assert np.linalg.norm(pupils[0] - pupils[1]) == pytest.approx(6.4)


def test_points_that_are_no_face_or_of_another_mesh_are_refused(face: SheetFace) -> None:
    flat = face.points.copy()
    flat[CONTROL_POINT_INDEX["pupil_l"]] = flat[CONTROL_POINT_INDEX["pupil_r"]]
    with pytest.raises(ValueError, match="pupils, nose, lids and lips must lie apart"):
        prepare_face(face.mesh, flat)
    with pytest.raises(ValueError, match="most of them do not lie on it; place them again with `conf fit`"):
        prepare_face(face.mesh, face.points + np.array([0, 0, 50]))
