from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box


def test_rectangles_have_exact_colours_and_are_clipped(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    window.begin()
    with overlay.frame(window):
        draw_list = imgui.get_background_draw_list()
        draw_list.push_clip_rect(imgui.ImVec2(0, 0), imgui.ImVec2(60, 25))
        draw_list.add_rect_filled(imgui.ImVec2(10, 20), imgui.ImVec2(100, 90), imgui.IM_COL32(10, 20, 30, 255))
        draw_list.pop_clip_rect()
    pixels = window.read()
    assert box(pixels.any(axis=2)) == (10, 20, 60, 25)
    assert pixels[22, 30].tolist() == [30, 20, 10]


def test_glyphs_used_for_the_first_time_are_uploaded(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    counts = []
    for text in ("", "abc", "ÄÖÜ 0123456789 WMQ"):
        window.begin()
        with overlay.frame(window):
            imgui.get_foreground_draw_list().add_text(imgui.ImVec2(5, 5), imgui.IM_COL32(255, 255, 255, 255), text)
        counts.append(int((window.read() > 128).sum()))
    assert counts[0] == 0 < counts[1] < counts[2]


def test_panels_are_blended_with_the_image(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    window.begin()
    window.framebuffer.clear(0.0, 0.0, 1.0)
    with overlay.frame(window):
        draw_list = imgui.get_background_draw_list()
        draw_list.add_rect_filled(imgui.ImVec2(0, 0), imgui.ImVec2(50, 50), imgui.IM_COL32(255, 255, 255, 51))
    pixels = window.read()
    assert pixels[100, 100].tolist() == [255, 0, 0]
    assert pixels[20, 20].tolist() == [255, 51, 51]
