import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.deformation.rig_builder import RigJoints, build_rig, read_joints
from conf.face.mesh.mesh import Mesh, load_mesh
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """Return the default head."""
    return load_mesh(DEFAULT_HEAD)


@pytest.mark.slow
def test_the_default_head_has_two_eyes_and_a_jaw(mesh: Mesh) -> None:
    rig = build_rig(mesh, default_points(), default_joints())
    assert [eye.pupil for eye in rig.eyes] == [16, 17]
    assert all(len(eye.vertices) and len(eye.lids) for eye in rig.eyes)
    assert rig.jaw is not None
    assert rig.jaw.vertices.tolist() == mesh.group_vertices("teeth_lower", "tongue").tolist()
    assert set(rig.jaw.weights) == {1.0}
    assert not rig.jaw.point_weights.any()
    assert len(rig.anchors) >= 10


def test_blendshapes_give_the_skin_jaw_weights(mesh: Mesh) -> None:
    blendshapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(mesh.vertices))
    jaw = build_rig(mesh, default_points(), default_joints(), blendshapes).jaw
    assert jaw is not None
    assert jaw.point_weights[0] > 0.9  # the chin
    assert jaw.point_weights[26:32] == pytest.approx(0)  # the brows
    assert 0 < jaw.weights.min() and jaw.weights.max() <= 1.0


def test_a_mesh_without_the_groups_has_no_rigid_parts(face: SheetFace) -> None:
    rig = build_rig(face.mesh, face.points, RigJoints({}))
    assert (rig.eyes, rig.jaw, len(rig.rigid), len(rig.anchors)) == ((), None, 0, 0)


def test_a_rig_has_the_parts_of_its_joints(mesh: Mesh) -> None:
    points, joints = default_points(), default_joints()
    no_joints = build_rig(mesh, points, RigJoints({}))
    assert (no_joints.eyes, no_joints.jaw, len(no_joints.anchors)) == ((), None, 0)
    assert len(no_joints.rigid)  # teeth stay rigid without a hinge
    one_eye = build_rig(mesh, points, RigJoints({"eye_r": joints.eyes["eye_r"]}, joints.hinge))
    assert [eye.pupil for eye in one_eye.eyes] == PUPILS[1:]
    assert one_eye.jaw is not None


def test_lid_vertices_are_skin_outside_the_eyeball(mesh: Mesh) -> None:
    rig = build_rig(mesh, default_points(), default_joints())
    for eye in rig.eyes:
        assert not np.isin(eye.lids, rig.rigid).any()
        neutral = np.linalg.norm(mesh.vertices[eye.lids] - eye.centre, axis=1)
        assert (eye.clearance <= neutral + 1e-6).all()


def test_lids_are_the_skin_near_the_eyeball_and_may_come_to_rest_on_it(mesh: Mesh) -> None:
    rig = build_rig(mesh, default_points(), default_joints())
    for eye in rig.eyes:
        radius = np.linalg.norm(mesh.vertices[eye.vertices] - eye.centre, axis=1).max()
        distance = np.linalg.norm(mesh.vertices - eye.centre, axis=1)
        skin = np.setdiff1d(np.arange(len(distance)), rig.rigid)
        assert set(skin[distance[skin] < 1.34 * radius]) <= set(eye.lids) <= set(skin[distance[skin] < 1.36 * radius])
        outside = distance[eye.lids] > radius + 0.1
        assert outside.any()
        assert eye.clearance[outside] == pytest.approx(radius + 0.03)
        assert eye.clearance.dtype == np.float32


def test_an_eye_without_an_eyeball_has_no_lids(mesh: Mesh, face: SheetFace) -> None:
    (eye,) = build_rig(face.mesh, face.points, RigJoints({"eye_r": face.mesh.vertices[3000]})).eyes
    assert len(eye.vertices) == len(eye.lids) == len(eye.clearance) == 0


@pytest.mark.slow
def test_a_jaw_holds_arms_from_its_centre_by_weight(mesh: Mesh) -> None:
    points, joints = default_points(), default_joints()
    blendshapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(mesh.vertices))
    jaw = build_rig(mesh, points, joints, blendshapes).jaw
    assert jaw is not None and joints.hinge is not None
    assert jaw.centre.tolist() == joints.hinge[0].tolist()
    arms = jaw.weighted_offsets / jaw.weights[:, None]
    assert arms == pytest.approx(mesh.vertices[jaw.vertices] - jaw.centre, abs=1e-3)
    moved = jaw.point_weights > 0
    arms = jaw.weighted_point_offsets[moved] / jaw.point_weights[moved, None]
    assert arms == pytest.approx(points[moved] - jaw.centre, abs=1e-3)
    assert not jaw.weighted_point_offsets[~moved].any()
    arrays = (jaw.weights, jaw.weighted_offsets, jaw.point_weights, jaw.weighted_point_offsets)
    assert {array.dtype for array in arrays} == {np.dtype(np.float32)}


def test_a_positive_jaw_angle_opens_the_mouth_for_either_axis_direction(mesh: Mesh) -> None:
    points, hinge = default_points(), default_joints().hinge
    assert hinge is not None
    centre, axis = hinge
    for direction in (axis, -2 * axis):
        jaw = build_rig(mesh, points, RigJoints({}, (centre, direction))).jaw
        assert jaw is not None
        assert np.cross(jaw.axis, points[CONTROL_POINT_INDEX["chin_bottom"]] - centre)[1] < 0
        assert np.linalg.norm(jaw.axis) == 1


def test_joints_are_read_as_far_as_they_are_given(tmp_path: Path) -> None:
    (tmp_path / "rig.json").write_text('{"anchors": [[0, 0, 1]], "eye_r": {"centre": [1, 2, 3]}}')
    joints = read_joints(tmp_path / "rig.json")
    assert {name: centre.tolist() for name, centre in joints.eyes.items()} == {"eye_r": [1, 2, 3]}
    assert joints.hinge is None
    assert joints.anchors.tolist() == [[0, 0, 1]]
    assert joints.anchors.dtype == joints.eyes["eye_r"].dtype == np.float64
    (tmp_path / "rig.json").write_text('{"eye_l": {"centre": [1000000, -1000000, 0]}}')
    joints = read_joints(tmp_path / "rig.json")
    assert joints.anchors.shape == (0, 3)
    assert joints.eyes["eye_l"].tolist() == [1e6, -1e6, 0]


def test_a_rig_file_has_at_most_a_megabyte(tmp_path: Path) -> None:
    (tmp_path / "rig.json").write_text("{}" + " " * ((1 << 20) - 2))
    assert read_joints(tmp_path / "rig.json").hinge is None
    (tmp_path / "rig.json").write_text("{}" + " " * ((1 << 20) - 1))
    with pytest.raises(FileFormatError):
        read_joints(tmp_path / "rig.json")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "7",
        '{"eye_l": 3}',
        '{"jaw": null}',
        '{"jaw": {"centre": [0, 0, 0]}}',
        '{"anchors": [[1, 2]]}',
        '{"anchors": [[1e9, 0, 0]]}',
        '{"anchors": [["x", 0, 0]]}',
        '{"eye_l": {"centre": [NaN, 0, 0]}}',
        "[" * 100_000,
        '{"anchors": null}',
    ],
)
def test_malformed_rig_files_raise_file_format_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "rig.json"
    path.write_text(text)
    with pytest.raises(FileFormatError, match=r"rig\.json: expected a rig: eyes, jaw and anchors"):
        read_joints(path)


@pytest.mark.slow
@given(
    st.recursive(
        st.none() | st.floats() | st.text(max_size=3),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(
                st.sampled_from(["eye_l", "eye_r", "jaw", "centre", "axis", "anchors"]), inner, max_size=4
            )
        ),
        max_leaves=12,
    )
)
def test_any_json_gives_joints_or_file_format_error(tmp_path_factory: pytest.TempPathFactory, value: object) -> None:
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_text(json.dumps(value))
    try:
        read_joints(path)
    except FileFormatError:
        pass
