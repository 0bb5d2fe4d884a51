import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from conf.face.head_pose import HeadPose
from conf.render.camera import FACE_PLANE_CM, PITCH_LIMIT, ZOOM_LIMITS, ViewState, clip_matrix, project, view_rotation

number = st.floats(-0.4, 0.4)
angles = st.tuples(number, number, number)
poses = st.builds(
    lambda rotation, x, y, scale: HeadPose(np.array(rotation), np.array([x, y]), scale),
    angles, number, number, st.floats(-5.0, -2.5),
)  # fmt: skip
views = st.builds(ViewState, yaw=number, pitch=number, zoom=st.floats(0.5, 2.0), pan=st.tuples(number, number))
sizes = st.tuples(st.integers(16, 2000), st.integers(16, 2000))


@pytest.mark.slow
@given(poses, views, sizes)
def test_the_face_plane_is_projected_as_by_the_orthographic_pose(
    pose: HeadPose, view: ViewState, size: tuple[int, int]
) -> None:
    rotation, scale = view_rotation(pose, view), np.exp(pose.log_scale)
    depth = rotation.T[:, 2] * FACE_PLANE_CM * rotation[2, 2]  # the centre of the face plane
    points = depth + np.array([[-3.2, 2.6], [3.2, -4.0], [0.0, 0.0]]) @ rotation[:2]
    projected = project(points, clip_matrix(pose, view, aspect=size[0] / size[1]), size)
    heights = view.zoom * ((points @ rotation.T)[:, :2] * scale + pose.position) + view.pan
    expected = np.array(size) / 2 + heights * [1, -1] * size[1]
    np.testing.assert_allclose(projected, expected, atol=1e-6)


@pytest.mark.slow
@given(poses, sizes)
def test_a_nearer_segment_is_larger_and_in_front(pose: HeadPose, size: tuple[int, int]) -> None:
    rotation = view_rotation(pose, ViewState())
    matrix = clip_matrix(pose, ViewState(), aspect=size[0] / size[1])
    near, far = (np.array([[-1.0, 0.0, z], [1.0, 0.0, z]]) @ rotation for z in (9.0, -9.0))
    widths = [float(np.linalg.norm(np.diff(project(pair, matrix, size), axis=0))) for pair in (near, far)]
    depths = [float(matrix[2] @ [*pair[0], 1.0]) / float(matrix[3] @ [*pair[0], 1.0]) for pair in (near, far)]
    assert widths[0] > widths[1]
    assert -1 < depths[0] < depths[1] < 1


@pytest.mark.slow
@given(poses, views)
def test_the_view_rotation_is_orthogonal_and_proper(pose: HeadPose, view: ViewState) -> None:
    rotation = view_rotation(pose, view)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_the_nose_follows_a_drag() -> None:
    front = HeadPose(np.zeros(3), np.zeros(2), -3.0)
    nose = np.array([0.0, 0.0, 1.0])
    assert (view_rotation(front, ViewState().orbited(0.1, 0.0)) @ nose)[0] > 0.2
    assert (view_rotation(front, ViewState().orbited(0.0, 0.1)) @ nose)[1] > 0.2


def test_the_viewer_orbits_about_the_image_axes() -> None:
    pose = HeadPose(Rotation.from_euler("Z", 0.5).as_rotvec(), np.zeros(2), -3.0)
    left_ear = view_rotation(pose, ViewState(yaw=np.pi / 2)) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(left_ear, [0.0, np.sin(0.5), -np.cos(0.5)], atol=1e-12)


@pytest.mark.slow
@given(st.lists(st.tuples(st.sampled_from(["orbited", "panned"]), number, number), max_size=20), st.integers(-90, 90))
def test_drags_and_wheel_steps_stay_within_the_limits(moves: list[tuple[str, float, float]], steps: int) -> None:
    view = ViewState().zoomed(steps)
    for name, dx, dy in moves:
        view = getattr(view, name)(dx, dy)
    assert abs(view.pitch) <= PITCH_LIMIT
    assert ZOOM_LIMITS[0] <= view.zoom <= ZOOM_LIMITS[1]
    assert view.reset() == ViewState()


def test_reset_keeps_the_switches() -> None:
    assert ViewState(yaw=1.0, wireframe=True).reset() == ViewState(wireframe=True)


def test_toggling_twice_changes_nothing_and_other_names_are_refused() -> None:
    assert ViewState().toggled("points").points
    assert ViewState().toggled("stats").toggled("stats") == ViewState()
    with pytest.raises(ValueError, match="name must be one of wireframe, points"):
        ViewState().toggled("yaw")
