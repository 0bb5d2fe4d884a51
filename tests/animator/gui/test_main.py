import itertools
from dataclasses import replace

import numpy as np
import pytest

from conf.animator.controller import Controller
from conf.animator.gui.layout import Layout
from conf.animator.gui.main import AnimatorGui
from conf.animator.state.point_placement import PointPlacement
from conf.animator.viewport_controller import ViewportController
from conf.render.ui.theme import themed
from tests.support.imgui_stage import Stage


@pytest.mark.slow
def test_notice_help_and_reference_face_are_drawn(stage: Stage, controller: Controller) -> None:
    gui, viewport, size = AnimatorGui(stage.overlay), ViewportController(controller), stage.window.size
    layout = Layout.of(size, 0.5)

    def render() -> np.ndarray:
        for _ in range(2):
            gui.prepare(controller)
            stage.window.begin()
            with stage.overlay.frame(stage.window, scale=0.5), themed(0.5):
                gui.draw(controller, viewport, layout, 1.0, 60.0)
        return stage.window.read()

    plain = render()
    controller.notice = "something was saved"
    with_notice = render()
    assert controller.notice == "" and gui.notice == "something was saved"
    controller.state = replace(controller.state, show_help=True)
    with_help = render()
    controller.state = replace(controller.state, show_help=False, placement=PointPlacement())
    with_reference = render()
    images = [plain, with_notice, with_help, with_reference]
    assert all((a != b).any() for a, b in itertools.pairwise(images))
    rows = slice(round(layout.reference.y) + 5, None)
    assert with_reference[rows, : round(layout.reference.width)].mean() > plain[rows, :60].mean() + 20
    gui.release()
