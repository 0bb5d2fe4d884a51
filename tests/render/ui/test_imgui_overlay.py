import numpy as np
import pytest
from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import MUTED, PANEL, ImGuiOverlay, lines_height, panel
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box


def test_a_panel_covers_exactly_its_rectangle(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    window.begin()
    window.framebuffer.clear(1.0, 1.0, 1.0)
    with overlay.frame(window):
        padding = imgui.get_style().window_padding
        with panel("test", (300, 200), (1.0, 1.0), (100, lines_height(2))):
            imgui.text("first")
            imgui.text("second")
        expected = (round(300 - 100 - 2 * padding.x), 200 - lines_height(2) - 2 * padding.y, 300, 200)
    np.testing.assert_allclose(box((window.read() != 255).any(axis=2)), expected, atol=1)


def test_a_new_context_can_be_created_after_release(window: OffscreenWindow) -> None:
    before = imgui.get_current_context()
    for _ in range(2):
        overlay = ImGuiOverlay(window.ctx)
        with overlay.frame(window):
            pass
        overlay.release()
    assert imgui.get_current_context() in (None, before)


def test_a_frame_can_be_drawn_after_one_that_raised(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    with pytest.raises(RuntimeError, match="mine"), overlay.frame(window):
        raise RuntimeError("mine")
    with overlay.frame(window):
        pass


def test_no_settings_file_is_written(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    assert not imgui.get_io().get_ini_filename()


def test_text_fields_use_the_clipboard_of_the_window(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    overlay.connect_clipboard(window)
    window.clipboard = "from elsewhere"
    with overlay.frame(window):
        assert imgui.get_clipboard_text() == "from elsewhere"
        imgui.set_clipboard_text("acorn-tulip-river-42")
    assert window.clipboard == "acorn-tulip-river-42"


def test_muted_text_is_legible_over_a_white_image() -> None:
    def luminance(colour: np.ndarray) -> float:  # WCAG 2.1
        linear = np.where(colour <= 0.03928, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
        return float(linear @ (0.2126, 0.7152, 0.0722))

    panel_over_white = np.array(PANEL[:3]) * PANEL[3] + (1 - PANEL[3])
    contrast = (luminance(np.array(MUTED[:3])) + 0.05) / (luminance(panel_over_white) + 0.05)
    assert contrast >= 4.5
