from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.call_stats import CallStats
from conf.receiver.stats_overlay import (
    MARGIN,
    WIDTH,
    draw_stats,
    draw_stats_line,
    format_bitrate,
    format_saved,
    line_parts,
    stat_lines,
    stats_size,
)
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import Pixels, box

TRAFFIC = TrafficSnapshot(1234, 3, 1, 1300, 0, 29.8, 48.2, 5.78, 230400, 27648.0, 4783.0, 4.12, 67.0)
STATS = CallStats("receiving", 29.8, TRAFFIC, 50, 320, 240, 24.0, (5.0, 6.0, 5.5, 5.8), 30.0)


def test_the_lines_show_the_statistics_with_their_units() -> None:
    assert dict(stat_lines(STATS)) == {
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


def test_an_unknown_round_trip_time_is_left_out() -> None:
    assert "round trip" not in dict(stat_lines(replace(STATS, round_trip_ms=None)))


@given(st.floats(1.0, 1e12))
def test_the_percentage_saved_is_never_rounded_up_to_all(ratio: float) -> None:
    percent = float(format_saved(ratio).removesuffix(" %"))
    assert percent < 100.0 and percent == pytest.approx(100 * (1 - 1 / ratio), abs=0.01)


def test_nothing_is_saved_before_there_is_traffic() -> None:
    assert format_saved(0.0) == "0.00 %"


@given(st.floats(0.0, 1e7))
def test_bit_rates_keep_their_value(kbps: float) -> None:
    value, unit = format_bitrate(kbps).split()
    assert float(value) * {"kbit/s": 1, "Mbit/s": 1000}[unit] == pytest.approx(kbps, abs=0.06, rel=0.06)


def drawn(window: OffscreenWindow, overlay: ImGuiOverlay, stats: CallStats) -> Pixels:
    window.begin((1.0, 1.0, 1.0, 1.0))
    with overlay.frame(window):
        draw_stats(overlay, stats)
    return window.read()


@pytest.mark.parametrize(("size", "max_bottom"), [((640, 480), 320), ((1280, 720), 400), ((320, 240), 120)])
def test_only_the_panel_in_the_upper_left_is_drawn(size: tuple[int, int], max_bottom: int) -> None:
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        left, top, right, bottom = box((drawn(window, overlay, STATS) != 255).any(axis=2))
        margin = MARGIN * overlay.scale
        assert (left, top) == pytest.approx((margin, margin), abs=1)
        assert right < margin + (WIDTH + 24) * overlay.scale
        assert bottom < max_bottom


def test_the_state_has_a_colour(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    green = drawn(window, overlay, STATS).astype(int)
    red = drawn(window, overlay, replace(STATS, state="lost")).astype(int)
    line = slice(8, 24), slice(8, 60)
    assert (green[line][..., 1] - green[line][..., 2]).max() > 60
    assert (red[line][..., 2] - red[line][..., 1]).max() > 60


@pytest.mark.parametrize("history", [(), (0.0,), (0.0, 0.0), tuple(map(float, range(500)))])
def test_a_history_of_any_length_is_drawn(history: tuple[float, ...]) -> None:
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:
        pixels = drawn(window, overlay, replace(STATS, history=history))
    assert np.any(pixels != 255)


def test_the_line_has_the_state_the_bit_rate_and_the_ratio() -> None:
    assert [text for text, _ in line_parts(STATS)] == ["receiving", "5.8 kbit/s", "4,783 : 1", "30 fps", "M: more"]


def test_without_traffic_the_line_has_no_figures_of_a_call() -> None:
    nothing = TrafficSnapshot(0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0)
    waiting = replace(STATS, state="waiting", traffic=nothing)
    assert [text for text, _ in line_parts(waiting)] == ["waiting", "30 fps", "M: more"]


@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 720)])
@pytest.mark.parametrize("is_open", [False, True])
def test_the_statistics_have_the_size_that_is_told(size: tuple[int, int], is_open: bool) -> None:
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        window.begin((1.0, 1.0, 1.0, 1.0))
        with overlay.frame(window):
            draw_stats(overlay, STATS) if is_open else draw_stats_line(overlay, STATS)
            width, height = stats_size(overlay, STATS, is_open=is_open)
            one_line = overlay.scale * 40
        left, top, right, bottom = box((window.read() != 255).any(axis=2))
    assert (right - left, bottom - top) == pytest.approx((width, height), abs=2)
    assert is_open or height < one_line
