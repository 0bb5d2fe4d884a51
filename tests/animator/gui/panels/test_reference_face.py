from conf.animator.gui.layout import REFERENCE
from conf.animator.gui.panels.reference_face import ReferenceFace, reference_clip_matrix
from conf.animator.picking import Rect
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from tests.support.imgui_stage import Stage


def test_every_point_is_in_the_picture_and_a_click_picks_it(stage: Stage, head: FaceModel) -> None:
    reference = ReferenceFace(stage.window.ctx, head, REFERENCE)
    rect = Rect(20, 100, 300, 300 * REFERENCE)
    pixels = rect.to_pixels(head.control_points, reference_clip_matrix((640, round(640 * REFERENCE))))
    assert all(rect.contains(x, y) for x, y in pixels)
    picked: list[int] = []

    def draw() -> None:
        point = reference.draw(stage.overlay, rect, PointPlacement())
        if point is not None:
            picked.append(point)

    stage.frame(draw)
    nose = CONTROL_POINT_INDEX["nose_bottom_edge_l"]
    stage.click(*pixels[nose], draw)
    assert picked == [nose]
    reference.release()
