import numpy as np
import pytest

from conf.receiver.hud import draw_help, draw_toast, help_lines
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.input_events import KEYS
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box


def test_the_help_names_every_key_and_the_mouse() -> None:
    lines = dict(help_lines())
    assert lines["Space"] == "pause and go on"
    assert lines["Esc, Q"] == "quit"
    assert lines["drag"] == "turn the head"
    listed = {key for keys in lines for key in keys.split(", ")}
    assert len(listed) == len(KEYS) + 3


@pytest.mark.usefixtures("gl")
def test_the_help_is_in_the_middle_and_the_notice_at_the_bottom() -> None:
    with OffscreenWindow(640, 480) as window:
        overlay = ImGuiOverlay(window.ctx)
        boxes = []
        for draw in (draw_help, lambda overlay: draw_toast(overlay, "saved conf-001.jpg")):
            window.begin()
            window.framebuffer.clear(1.0, 1.0, 1.0)
            with overlay.frame(window.framebuffer, window.size, 1.0):
                draw(overlay)
            boxes.append(np.array(box((window.read() != 255).any(axis=2))))
        overlay.release()
    for left, top, right, bottom in boxes:
        assert abs((left + right) / 2 - 320) <= 2
        assert 0 < top and bottom <= 480
    assert abs((boxes[0][1] + boxes[0][3]) / 2 - 240) <= 2
    assert boxes[1][3] == 470
