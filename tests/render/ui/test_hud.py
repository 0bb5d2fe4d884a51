import numpy as np
import pytest
from imgui_bundle import imgui

from conf.render.ui.hud import (
    HAIR_SPACE,
    draw_help,
    draw_label,
    draw_recording_sign,
    draw_toast,
    figure_width,
    format_clock,
    help_size,
    label_size,
    sign_size,
    spaced_hyphens,
    toast_size,
)
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box

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


@pytest.mark.slow
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


def test_a_label_stands_below_and_right_of_its_corner(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    with overlay.frame(blank):
        draw_label("10.0.0.7:1234", (20.0, 30.0))
        width, height = label_size("10.0.0.7:1234")
    assert drawn_box(blank) == pytest.approx((20, 30, 20 + width, 30 + height), abs=1)


@pytest.mark.parametrize("max_width", [None, 120.0])
def test_panels_have_the_size_that_is_told(
    blank: OffscreenWindow, overlay: ImGuiOverlay, max_width: float | None
) -> None:
    sign = [("R", 7.0), ("D", 3723.9)]
    with overlay.frame(blank):
        sizes = [help_size(overlay, LINES), toast_size("saved conf-001.jpg here", max_width=max_width)]
        sizes.append(sign_size(overlay, sign))
        draws = [
            lambda: draw_help(overlay, LINES, (160, 120), opacity=1.0),
            lambda: draw_toast("saved conf-001.jpg here", (160, 200), max_width=max_width),
            lambda: draw_recording_sign(overlay, sign, (20, 20)),
        ]
    for size, draw in zip(sizes, draws, strict=True):
        blank.begin((1.0, 1.0, 1.0, 1.0))
        with overlay.frame(blank):
            draw()
        left, top, right, bottom = drawn_box(blank)
        assert (right - left, bottom - top) == pytest.approx(size, abs=2)


def test_each_recording_has_a_red_dot_and_a_clock(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    dots = []
    for recordings in ([("R", 7.0)], [("R", 7.0), ("D", 65.0)]):
        blank.begin((1.0, 1.0, 1.0, 1.0))
        with overlay.frame(blank):
            draw_recording_sign(overlay, recordings, (20, 20))
        pixels = blank.read().astype(int)
        red = (pixels[..., 2] > 200) & (pixels[..., 1] < 100)
        dots.append(red.any(axis=0).astype(int))
    assert [int((np.diff(row) == 1).sum()) for row in dots] == [1, 2]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0:00"), (7.9, "0:07"), (65.0, "1:05"), (754.0, "12:34"), (3600.0, "1:00:00"), (3723.5, "1:02:03")],
)
def test_a_clock_counts_whole_seconds(seconds: float, text: str) -> None:
    assert format_clock(seconds) == text


def test_a_running_figure_keeps_its_width(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    with overlay.frame(blank):
        assert figure_width("1:11") == figure_width("0:47")


def test_the_hyphens_of_an_option_are_drawn_apart(blank: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    assert spaced_hyphens("start with --code a-b") == f"start with -{HAIR_SPACE}-code a-b"
    blank.begin((1.0, 1.0, 1.0, 1.0))
    with overlay.frame(blank):
        imgui.get_foreground_draw_list().add_text(imgui.ImVec2(20, 20), 0xFF000000, spaced_hyphens("--"))
        row = imgui.ImVec2(20, 20), imgui.calc_text_size(spaced_hyphens("--"))
    left, right = round(row[0].x), round(row[0].x + row[1].x)
    columns = (blank.read()[20:60, left:right] < 128).any(axis=(0, 2)).astype(int)
    assert int((np.diff(columns, prepend=0) == 1).sum()) == 2
