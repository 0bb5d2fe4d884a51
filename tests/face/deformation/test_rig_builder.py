import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.deformation.rig_builder import RigJoints, build_rig
from conf.face.mesh.mesh import load_mesh


def test_a_rig_has_what_its_joints_have() -> None:
    mesh, points, joints = load_mesh(DEFAULT_HEAD), default_points(), default_joints()
    nothing = build_rig(mesh, points, RigJoints({}))
    assert (nothing.eyes, nothing.jaw, len(nothing.anchors)) == ((), None, 0)
    assert len(nothing.rigid)  # teeth stay rigid without a hinge
    one_eye = build_rig(mesh, points, RigJoints({"eye_r": joints.eyes["eye_r"]}, joints.hinge))
    assert [eye.pupil for eye in one_eye.eyes] == PUPILS[1:]
    assert one_eye.jaw is not None


def test_lids_keep_off_the_eyeball_and_no_rigid_part_is_a_lid() -> None:
    mesh, points, joints = load_mesh(DEFAULT_HEAD), default_points(), default_joints()
    rig = build_rig(mesh, points, joints)
    for eye in rig.eyes:
        assert not np.isin(eye.lids, rig.rigid).any()
        at_rest = np.linalg.norm(mesh.vertices[eye.lids] - eye.centre, axis=1)
        assert (eye.clearance <= at_rest + 1e-6).all()


def test_whichever_way_the_hinge_points_the_chin_goes_down() -> None:
    mesh, points, joints = load_mesh(DEFAULT_HEAD), default_points(), default_joints()
    assert joints.hinge is not None
    centre, axis = joints.hinge
    for direction in (axis, -2 * axis):
        jaw = build_rig(mesh, points, RigJoints({}, (centre, direction))).jaw
        assert jaw is not None
        assert np.cross(jaw.axis, points[CONTROL_POINT_INDEX["chin_bottom"]] - centre)[1] < 0
        assert np.linalg.norm(jaw.axis) == 1
