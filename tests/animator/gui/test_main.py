import itertools
from dataclasses import replace

import numpy as np

from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance
from conf.animator.gui.layout import Layout
from conf.animator.gui.main import AnimatorGui
from conf.animator.gui.theme import themed
from conf.animator.state.editor import StatusInfo
from conf.animator.state.point_placement import PointPlacement
from conf.animator.viewport_controller import ViewportController
from conf.face.deformation.face_model import DeformerOptions
from tests.support.imgui_stage import Stage


def test_notice_help_and_reference_face_show_when_they_should(
    stage: Stage, subject: FaceDocument, facts: StatusInfo
) -> None:
    director = Controller(stage.window.ctx, FaceInstance(stage.window.ctx, subject, DeformerOptions()))
    interface, touch, size = AnimatorGui(stage.overlay), ViewportController(director), stage.window.size
    layout = Layout.of(size, 0.5)

    def shot() -> np.ndarray:
        for _ in range(2):
            interface.prepare(director)
            stage.window.begin()
            with stage.overlay.frame(stage.window, scale=0.5), themed(0.5):
                assert interface.draw(director, touch, layout, facts) == []
        return stage.window.read()

    plain = shot()
    director.notice = "something was saved"
    noticed = shot()
    director.desk = replace(director.desk, help=True)
    helped = shot()
    director.desk = replace(director.desk, help=False, placing=PointPlacement())
    placing = shot()
    pictures = [plain, noticed, helped, placing]
    assert all((a != b).any() for a, b in itertools.pairwise(pictures))
    below = layout.reference
    assert placing[round(below.y) + 5 :, : round(below.width)].mean() > plain[round(below.y) + 5 :, :60].mean() + 20
    interface.release()
    director.release()
