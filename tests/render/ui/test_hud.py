import numpy as np
import pytest

from conf.render.ui.hud import draw_help, draw_label, draw_toast
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box
from tests.support.stand_in_head import SIZE

LINES = [("H", "this help"), ("Esc, Q", "quit")]


@pytest.fixture
def blank(window: OffscreenWindow) -> OffscreenWindow:
    """A white window."""
    window.begin((1.0, 1.0, 1.0, 1.0))
    return window


def drawn_box(window: OffscreenWindow) -> tuple[int, int, int, int]:
    return box((window.read() != 255).any(axis=2))


def test_the_help_is_centred_and_its_opacity_is_set(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    with overlay.frame(blank):
        draw_help(overlay, LINES, (160, 120), opacity=1.0)
    left, top, right, bottom = drawn_box(blank)
    assert (left + right) / 2 == pytest.approx(160, abs=1) and (top + bottom) / 2 == pytest.approx(120, abs=1)
    assert blank.read()[bottom - 3, 160].max() < 30, "an opaque panel covers the white"


def test_a_toast_stands_on_its_anchor_and_is_wrapped_if_it_is_long(
    blank: OffscreenWindow, overlay: ImGuiOverlay
) -> None:
    boxes = []
    for max_width in (None, 100.0):
        blank.begin((1.0, 1.0, 1.0, 1.0))
        with overlay.frame(blank):
            draw_toast("saved conf-001.jpg in this folder", (160, 230), max_width=max_width)
        boxes.append(np.array(drawn_box(blank)))
    for left, _, right, bottom in boxes:
        assert abs((left + right) / 2 - 160) <= 1 and bottom == 230
    (_, one_line_top, *_), (left, wrapped_top, right, _) = boxes
    assert wrapped_top < one_line_top - 10 and right - left < 130


def test_a_label_stands_above_and_right_of_its_corner(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    with overlay.frame(blank):
        draw_label(overlay, "10.0.0.7:1234", (20.0, SIZE[1]))
    left, _, _, bottom = drawn_box(blank)
    assert 20 < left < 30 and SIZE[1] - 10 < bottom < SIZE[1]
