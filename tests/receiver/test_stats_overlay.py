from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.protocol.voice.formats import VoiceState
from conf.receiver.call_stats import CallStats
from conf.receiver.stats_overlay import (
    MARGIN,
    MEDIA,
    WIDTH,
    draw_stats,
    draw_stats_line,
    fitting_parts,
    format_bitrate,
    format_saved,
    line_parts,
    media_lines,
    stat_lines,
    stats_size,
    voice_lines,
)
from conf.receiver.voice.voice_status import CONCEALED, REASONS, VoiceStatus
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import Pixels, box

TRAFFIC = TrafficSnapshot(1234, 3, 1, 1300, 0, 29.8, 48.2, 5.78, 230400, 27648.0, 4783.0, 4.12, 67.0)
HISTORY = (MediaBytes(300, 200, 0, 200), MediaBytes(300, 250, 100, 200), MediaBytes(300, 0, 0, 150))
STATS = CallStats("receiving", 29.8, TRAFFIC, 50, 320, 240, 24.0, HISTORY, 30.0)
TALKING = replace(STATS, voice=VoiceStatus(-20.0, loudest=1))


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


@pytest.mark.slow
@pytest.mark.parametrize(("size", "max_bottom"), [((640, 480), 380), ((1280, 720), 475), ((320, 240), 120)])
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


@pytest.mark.parametrize("history", [(), (MediaBytes(),), (MediaBytes(),) * 2, HISTORY * 200])
def test_a_history_of_any_length_is_drawn(history: tuple[MediaBytes, ...]) -> None:
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:
        pixels = drawn(window, overlay, replace(STATS, history=history))
    assert np.any(pixels != 255)


def test_the_line_has_the_state_the_bit_rate_and_the_ratio() -> None:
    assert [part.text for part in line_parts(STATS)] == ["receiving", "5.8 kbit/s", "4,783 : 1", "30 fps", "M: more"]


def test_without_traffic_the_line_has_no_figures_of_a_call() -> None:
    nothing = TrafficSnapshot(0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0)
    waiting = replace(STATS, state="waiting", traffic=nothing)
    assert [part.text for part in line_parts(waiting)] == ["waiting", "30 fps", "M: more"]


@pytest.mark.slow
@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 720)])
@pytest.mark.parametrize("is_open", [False, True])
@pytest.mark.parametrize("stats", [STATS, TALKING])
def test_the_statistics_have_the_size_that_is_told(size: tuple[int, int], is_open: bool, stats: CallStats) -> None:
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        window.begin((1.0, 1.0, 1.0, 1.0))
        with overlay.frame(window):
            draw_stats(overlay, stats) if is_open else draw_stats_line(overlay, stats)
            width, height = stats_size(overlay, stats, is_open=is_open)
            one_line = overlay.scale * 40
        left, top, right, bottom = box((window.read() != 255).any(axis=2))
    assert (right - left, bottom - top) == pytest.approx((width, height), abs=2)
    assert is_open or height < one_line


def test_the_line_shows_the_level_of_the_voice_or_that_the_sound_is_off_and_what_is_wrong() -> None:
    voice = line_parts(TALKING)[4]
    assert (voice.text, voice.level) == ("voice", pytest.approx(2 / 3))
    muted = replace(STATS, voice=VoiceStatus(-20.0, muted=True, notes={1: CONCEALED}))
    assert [part.text for part in line_parts(muted)[4:]] == ["sound off", "voice concealed", "M: more"]


def test_the_panel_tells_volume_mute_and_the_state_of_the_voice() -> None:
    assert voice_lines(STATS) == []
    assert voice_lines(replace(STATS, voice=VoiceStatus(volume_db=-3.0))) == [("voice", ""), ("sound", "volume -3 dB")]
    assert voice_lines(replace(STATS, voice=VoiceStatus(notes={1: CONCEALED})))[0] == ("voice", "concealed")
    off = VoiceStatus(muted=True, notes={1: REASONS[VoiceState.OFF]})
    assert voice_lines(replace(STATS, voice=off)) == [("voice", "microphone off"), ("sound", "off")]


def test_each_medium_has_a_line_with_bytes_a_second() -> None:
    assert media_lines(MediaBytes(312.4, 1500, 0, 240)) == [
        ("face", "312 B/s"),
        ("voice", "1,500 B/s"),
        ("portrait", "0 B/s"),
        ("overhead", "240 B/s"),
    ]


@pytest.mark.slow
def test_where_there_is_no_room_the_line_keeps_the_state_and_the_voice() -> None:
    muted = replace(STATS, voice=VoiceStatus(-20.0, muted=True, notes={1: CONCEALED}))
    for size in (64, 64), (240, 180), (320, 240), (640, 480):
        with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
            window.begin()
            with overlay.frame(window):
                texts = [part.text for part in fitting_parts(line_parts(muted), overlay)]
                width, _ = stats_size(overlay, muted, is_open=False)
                margin = MARGIN * overlay.scale
        assert {"receiving", "sound off", "voice concealed"} <= set(texts)
        assert size[0] < 320 or margin + width + margin <= size[0] + 1
    assert len(texts) == len(line_parts(muted))


def test_the_curve_stacks_the_media_in_their_colours() -> None:
    background = 0.4  # of the curve: the panel, dark and transparent, over white
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:

        def colours(amounts: MediaBytes) -> list[str]:
            """Return the media whose colours a column of the curve has, from the bottom to the top."""
            pixels = drawn(window, overlay, replace(STATS, history=(amounts,) * 2))
            found: list[str] = []
            for pixel in pixels[118:74:-1, 40, ::-1] / 255 - background:
                if np.abs(pixel).max() > 0.08:
                    tints = {name: np.array(colour[:3]) - background for name, colour in MEDIA.items()}
                    nearest = min(tints, key=lambda name: float(np.abs(pixel - 0.6 * tints[name]).max()))
                    found += [nearest] if nearest not in found else []
            return found

        assert colours(MediaBytes(100, 100, 100, 100)) == list(MEDIA)
        assert colours(MediaBytes(face=100, overhead=100)) == ["face", "overhead"]
