import numpy as np
import pytest

from conf.animator.face_view import FaceView
from conf.animator.motion_player import REST_POSE
from conf.animator.state.editor import ViewSettings
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.render.camera import ViewState, clip_matrix
from tests.support.imgui_stage import Stage

pytestmark = pytest.mark.slow


def test_styles_differ_and_leave_no_trace(stage: Stage, head: FaceModel) -> None:
    view = FaceView(stage.window.ctx, head)
    images = []
    for settings in (
        ViewSettings(),
        ViewSettings(style="regions"),
        ViewSettings(lights="evening"),
        ViewSettings(style="wireframe"),
        ViewSettings(),
    ):
        stage.window.begin()
        view.draw(head.neutral, REST_POSE, settings, stage.window.framebuffer)
        images.append(stage.window.read())
    np.testing.assert_array_equal(images[0], images[-1])
    assert all((images[0] != other).any(axis=2).mean() > 0.1 for other in images[1:-1])
    view.release()


def test_occluded_points_are_detected_in_every_style(stage: Stage, head: FaceModel) -> None:
    view = FaceView(stage.window.ctx, head)
    points, cheeks = head.control_points, [CONTROL_POINT_INDEX["cheekbone_l"], CONTROL_POINT_INDEX["cheekbone_r"]]
    assert view.visible(points, np.eye(4)).all(), "before the first frame"
    for style in ("rendered", "wireframe", "regions"):
        for yaw, expected in ((0.0, [True, True]), (1.2, [False, True])):
            camera = ViewState(yaw=yaw)
            stage.window.begin()
            view.draw(head.neutral, REST_POSE, ViewSettings(camera, style), stage.window.framebuffer)
            clip = clip_matrix(REST_POSE, camera, aspect=400 / 900)
            assert view.visible(points[cheeks], clip).tolist() == expected, (style, yaw)
            assert view.visible(points, clip).mean() > 0.5
    assert not view.visible(points + np.array([100.0, 0, 0]), clip).any()
    view.release()
