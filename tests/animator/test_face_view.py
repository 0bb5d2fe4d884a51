import numpy as np

from conf.animator.face_view import FaceView
from conf.animator.motion_player import REST_POSE
from conf.animator.state.view_settings import ViewSettings
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.render.camera import ViewState, clip_matrix
from tests.support.imgui_stage import Stage


def test_styles_follow_each_other_without_a_trace(stage: Stage, head: FaceModel) -> None:
    picture = FaceView(stage.window.ctx, head)
    seen = []
    for look in (
        ViewSettings(),
        ViewSettings(style="regions"),
        ViewSettings(lights="evening"),
        ViewSettings(style="wireframe"),
        ViewSettings(),
    ):
        stage.window.begin()
        picture.draw(head.neutral, REST_POSE, look, stage.window.framebuffer)
        seen.append(stage.window.read())
    np.testing.assert_array_equal(seen[0], seen[-1])
    assert all((seen[0] != other).any(axis=2).mean() > 0.1 for other in seen[1:-1])
    picture.release()


def test_points_on_the_far_side_are_known_in_every_style(stage: Stage, head: FaceModel) -> None:
    picture = FaceView(stage.window.ctx, head)
    points, cheeks = head.control_points, [CONTROL_POINT_INDEX["cheekbone_l"], CONTROL_POINT_INDEX["cheekbone_r"]]
    assert picture.visible(points, np.eye(4)).all(), "nothing hides anything before there is a picture"
    for style in ("rendered", "wireframe", "regions"):
        for yaw, wanted in ((0.0, [True, True]), (1.2, [False, True])):
            view = ViewState(yaw=yaw)
            stage.window.begin()
            picture.draw(head.neutral, REST_POSE, ViewSettings(view, style), stage.window.framebuffer)
            clip = clip_matrix(REST_POSE, view, aspect=400 / 900)
            assert picture.visible(points[cheeks], clip).tolist() == wanted, (style, yaw)
            assert picture.visible(points, clip).mean() > 0.5
    assert not picture.visible(points + np.array([100.0, 0, 0]), clip).any()
    picture.release()
