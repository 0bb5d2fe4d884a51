import pytest

from conf.animator.gui.layout import REFERENCE_ASPECT
from conf.animator.gui.panels.reference_face import IMAGE_WIDTH, ReferenceFace, reference_clip_matrix
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.render.ui.rectangle import Rect
from tests.support.imgui_stage import Stage


@pytest.mark.slow
def test_every_point_is_inside_the_image_and_a_click_selects_it(stage: Stage, head: FaceModel) -> None:
    reference = ReferenceFace(stage.window.ctx, head, REFERENCE_ASPECT)
    rect = Rect(20, 100, 300, 300 * REFERENCE_ASPECT)
    clip = reference_clip_matrix((IMAGE_WIDTH, round(IMAGE_WIDTH * REFERENCE_ASPECT)))
    pixels = rect.to_pixels(head.control_points, clip)
    assert all(rect.contains(x, y) for x, y in pixels)
    clicked: list[int] = []

    def draw() -> None:
        point = reference.draw(stage.overlay, rect, PointPlacement())
        if point is not None:
            clicked.append(point)

    stage.frame(draw)
    nose = CONTROL_POINT_INDEX["nose_bottom_edge_l"]
    x, y = pixels[nose]
    stage.click(x, y, draw)
    assert clicked == [nose]
    reference.release()
