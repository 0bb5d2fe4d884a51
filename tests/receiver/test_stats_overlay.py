from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.stats_overlay import MARGIN, WIDTH, CallStats, draw_stats, format_bitrate, format_saved, stat_lines
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box

READING = CallStats(
    "receiving", 29.8, 48.2, 5.78, 230400.0, 27648.0, 4783.0, 99.979, 50, 320, 240, 1234, 3, 1, 67.0, 4.12, 24.0,
    (5.0, 6.0, 5.5, 5.8), 30.0,
)  # fmt: skip


def test_the_rows_say_what_was_measured() -> None:
    assert dict(stat_lines(READING)) == {
        "raw pixels": "27.6 Mbit/s",
        "a raw frame": "230,400 B",
        "ratio": "4,783 : 1",
        "saved": "99.98 %",
        "50 points": "76,800 pixels",
        "received": "1,234",
        "lost / late": "3 / 1",
        "playout delay": "67 ms",
        "jitter": "4.1 ms",
        "round trip": "24 ms",
    }


def test_a_round_trip_nobody_measured_is_left_out() -> None:
    assert "round trip" not in dict(stat_lines(replace(READING, round_trip_ms=None)))


@given(st.floats(0.0, 100.0, exclude_max=True))
def test_what_is_saved_is_never_rounded_up_to_all(percent: float) -> None:
    assert float(format_saved(percent).removesuffix(" %")) < 100.0


@given(st.floats(0.0, 1e7))
def test_bit_rates_keep_their_value(kbps: float) -> None:
    value, unit = format_bitrate(kbps).split()
    assert float(value) * {"kbit/s": 1, "Mbit/s": 1000}[unit] == pytest.approx(kbps, abs=0.06, rel=0.06)


def drawn(window: OffscreenWindow, overlay: ImGuiOverlay, reading: CallStats, size: tuple[int, int]) -> np.ndarray:
    window.begin()
    window.framebuffer.clear(1.0, 1.0, 1.0)
    with overlay.frame(window.framebuffer, size, 1.0):
        draw_stats(overlay, reading)
    return window.read()


@pytest.mark.parametrize(("size", "most"), [((640, 480), 320), ((1280, 720), 400), ((320, 240), 120)])
@pytest.mark.usefixtures("gl")
def test_the_meter_keeps_to_its_panel_at_the_upper_left(size: tuple[int, int], most: int) -> None:
    with OffscreenWindow(*size) as window:
        overlay = ImGuiOverlay(window.ctx)
        pixels = drawn(window, overlay, READING, size)
        left, top, right, bottom = box((pixels != 255).any(axis=2))
        margin = MARGIN * overlay.scale
        assert (left, top) == pytest.approx((margin, margin), abs=1)
        assert right < margin + (WIDTH + 24) * overlay.scale
        assert bottom < most
        overlay.release()


def test_the_state_is_told_by_its_colour(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    green = drawn(window, overlay, READING, window.size).astype(int)
    red = drawn(window, overlay, replace(READING, state="lost"), window.size).astype(int)
    line = slice(8, 24), slice(8, 60)
    assert (green[line][..., 1] - green[line][..., 2]).max() > 60
    assert (red[line][..., 2] - red[line][..., 1]).max() > 60


@pytest.mark.parametrize("history", [(), (0.0,), (0.0, 0.0), tuple(map(float, range(500)))])
@pytest.mark.usefixtures("gl")
def test_any_history_is_drawn(history: tuple[float, ...]) -> None:
    with OffscreenWindow(640, 480) as window:
        overlay = ImGuiOverlay(window.ctx)
        pixels = drawn(window, overlay, replace(READING, history=history), window.size)
        overlay.release()
    assert (pixels != 255).any()
