import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, clip_matrix, project
from conf.render.control_point_markers import CELL, DOT_COLOUR, GRID, ControlPointMarkers, render_label_atlas
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow
from tests.support.stand_in_head import SIZE

FRONT = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.03)))
ISOLATED = [
    CONTROL_POINT_INDEX[name]
    for name in ("brow_outer_l", "brow_outer_r", "cheekbone_l", "cheekbone_r", "cheek_center_l")
]


def dots(window: OffscreenWindow, face: FaceModel, pose: HeadPose, view: ViewState) -> NDArray[np.bool_]:
    renderer = FaceRenderer(window.ctx, face)
    window.begin()
    renderer.draw(face.neutral, pose, view, window.framebuffer)
    renderer.release()
    difference = np.abs(window.read()[:, :, ::-1].astype(int) - DOT_COLOUR)
    return np.asarray((difference < 30).all(axis=2))


@pytest.mark.slow
def test_markers_are_drawn_at_the_projected_points(window: OffscreenWindow, face: FaceModel) -> None:
    found = dots(window, face, FRONT, ViewState(points=True))
    expected = project(face.control_points, clip_matrix(FRONT, ViewState(), aspect=SIZE[0] / SIZE[1]), SIZE)
    for x, y in expected[ISOLATED]:
        assert found[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].any()


@pytest.mark.slow
def test_no_markers_are_drawn_unless_they_are_switched_on(window: OffscreenWindow, face: FaceModel) -> None:
    assert not dots(window, face, FRONT, ViewState()).any()


@pytest.mark.slow
def test_the_face_hides_the_markers_behind_it(window: OffscreenWindow, face: FaceModel) -> None:
    back = HeadPose(Rotation.from_euler("Y", np.pi).as_rotvec(), FRONT.position, FRONT.log_scale)
    assert not dots(window, face, back, ViewState(points=True)).any()


@pytest.mark.slow
def test_the_points_move_with_the_vertices(window: OffscreenWindow, face: FaceModel) -> None:
    markers = ControlPointMarkers(window.ctx, face.control_points, face.mesh.vertices)
    np.testing.assert_allclose(markers.positions(face.neutral), face.control_points, atol=1e-5)
    moved = markers.positions(face.neutral + np.float32(1.5))
    np.testing.assert_allclose(moved, face.control_points + 1.5, atol=1e-5)
    markers.release()


def test_every_label_stays_inside_its_cell_and_is_unique() -> None:
    labels = render_label_atlas(50)
    cells = labels.reshape(GRID[1], CELL, GRID[0], CELL, 4).swapaxes(1, 2).reshape(-1, CELL, CELL, 4)
    assert len({cell.tobytes() for cell in cells}) == 50
    assert not cells[:, [0, -1], :, 3].any() and not cells[:, :, [0, -1], 3].any()
