from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import DEFAULT_HEAD, EYE_MIDPOINT, default_joints, default_points
from conf.face.fitting.custom_face import PreparedFace, find_file_to_model, prepare_face
from conf.face.fitting.default_texture import TEXTURE_FILE
from conf.face.mesh.mesh import Mesh, load_mesh
from tests.support.modified_heads import EYEBALLS, MOUTH, head_without
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def unprepared() -> Mesh:
    """Return the default head without groups and texture, lying on its back, in millimetres."""
    head = load_mesh(DEFAULT_HEAD)
    groups = {"default": np.arange(len(head.triangles))}
    return replace(head, vertices=head.vertices @ on_its_back().T * 10, groups=groups, texture=None)


@pytest.fixture(scope="module")
def prepared(unprepared: Mesh) -> PreparedFace:
    return prepare_face(unprepared, default_points() @ on_its_back().T * 10)


def on_its_back() -> np.ndarray:
    return Rotation.from_rotvec([-np.pi / 2, 0, 0]).as_matrix()


@pytest.mark.slow
def test_a_face_is_transformed_to_model_centimetres_and_back(unprepared: Mesh, prepared: PreparedFace) -> None:
    np.testing.assert_allclose(prepared.points, default_points(), atol=0.02)
    positions = prepared.file_to_model.inverse_apply(prepared.mesh.vertices)
    np.testing.assert_allclose(positions[: len(unprepared.vertices)], unprepared.vertices, atol=1e-9)


def test_eyes_and_jaw_are_rigged(prepared: PreparedFace) -> None:
    assert [eye.pupil for eye in prepared.rig.eyes] == PUPILS
    jaw, hinge = prepared.rig.jaw, default_joints().hinge
    assert jaw is not None and hinge is not None
    assert jaw.centre == pytest.approx(hinge[0], abs=0.05)
    assert jaw.vertices.tolist() == prepared.mesh.group_vertices("teeth_lower", "tongue").tolist()
    assert not jaw.point_weights.any()
    assert set(prepared.mesh.group_vertices("teeth_upper")) <= set(prepared.rig.rigid)


@pytest.mark.slow
def test_the_default_texture_replaces_a_missing_one_only(unprepared: Mesh, prepared: PreparedFace) -> None:
    assert prepared.mesh.texture == TEXTURE_FILE
    textured = replace(unprepared, texture=DEFAULT_HEAD.with_name("skin.webp"))
    kept = prepare_face(textured, default_points() @ on_its_back().T * 10).mesh
    assert kept.texture == textured.texture
    np.testing.assert_array_equal(kept.uvs[: len(textured.uvs)], textured.uvs)
    assert {"eye_l", "mouth", "tongue"} <= set(kept.groups)


@pytest.mark.slow
def test_what_is_missing_is_put_in_and_stated(prepared: PreparedFace) -> None:
    assert [remark.split(":")[0] for remark in prepared.remarks] == ["tear film or lashes cover the eyes"]
    assert prepare_face(head_without(), default_points()).remarks == ()
    bare = prepare_face(head_without(*EYEBALLS, *MOUTH), default_points())
    assert bare.remarks == ("no eyeballs: put in", "no inside of the mouth: put in", "no teeth: put in")
    assert {*EYEBALLS, *MOUTH} <= set(bare.mesh.groups)


@pytest.mark.slow
def test_a_textured_face_gets_parts_with_a_texture_of_their_own() -> None:
    head = replace(head_without(*EYEBALLS, *MOUTH), texture=DEFAULT_HEAD.with_name("skin.webp"))
    face = prepare_face(head, default_points())
    assert face.remarks == ("no eyeballs: put in", "no inside of the mouth: put in", "no teeth: put in")
    numbers, mesh = face.mesh.materials_of_triangles(), face.mesh
    added = np.concatenate([mesh.groups[name] for name in (*EYEBALLS, *MOUTH)])
    is_own = np.ones(len(mesh.triangles), np.bool_)
    is_own[added] = False
    assert (numbers[is_own] == 0).all() and mesh.materials[0].image == head.texture
    assert (numbers[added] == -1).all() and mesh.texture == TEXTURE_FILE
    new = np.unique(mesh.triangles[added])
    assert (new >= len(head.vertices)).mean() > 0.95  # all but the border of the mouth
    whole = is_own & (mesh.triangles < len(head.vertices)).all(axis=1)
    kept = mesh.uvs[mesh.render_triangles[whole]]
    by_corners = {tuple(corners): row for row, corners in enumerate(head.triangles.tolist())}
    rows = [by_corners.get(tuple(corners), -1) for corners in mesh.triangles[whole].tolist()]
    found = np.array(rows) >= 0
    assert found.mean() > 0.99
    np.testing.assert_array_equal(kept[found], head.uvs[head.render_triangles[np.array(rows)[found]]])
    assert len(face.rig.eyes) == 2 and face.rig.jaw is not None


def test_a_nearly_upright_face_is_not_rotated() -> None:
    tilt = Rotation.from_rotvec([0.2, 0, 0]).as_matrix()
    transform = find_file_to_model(default_points() @ tilt.T * 3)
    assert transform.rotation.tolist() == np.eye(3).tolist()
    pupils = transform.apply(default_points() @ tilt.T * 3)[PUPILS]
    assert pupils.mean(axis=0) == pytest.approx(EYE_MIDPOINT)
    assert np.linalg.norm(pupils[0] - pupils[1]) == pytest.approx(6.4)


def test_points_that_do_not_fit_are_rejected(face: SheetFace) -> None:
    flat = face.points.copy()
    flat[CONTROL_POINT_INDEX["pupil_l"]] = flat[CONTROL_POINT_INDEX["pupil_r"]]
    with pytest.raises(ValueError, match="pupils, nose, lids and lips must lie apart"):
        prepare_face(face.mesh, flat)
    with pytest.raises(ValueError, match="most of them do not lie on it; place them again with `conf fit`"):
        prepare_face(face.mesh, face.points + np.array([0, 0, 50]))
