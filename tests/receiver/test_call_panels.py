from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.receiver.call_panels import CallPanels, NamePlate
from conf.receiver.call_stats import CallStats
from conf.receiver.panel_layout import Rect
from conf.receiver.participant_grid import layout_grid
from conf.receiver.stats_overlay import covered_width
from conf.receiver.viewer_controls import help_lines
from conf.receiver.voice.voice_status import CONCEALED, VoiceStatus
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

pytestmark = pytest.mark.slow

TRAFFIC = TrafficSnapshot(123456, 345, 123, 1300, 0, 29.8, 48.2, 443.7, 230400, 27648.0, 4783.0, 4.12, 67.0)
VOICE = VoiceStatus(-20.0, muted=True, loudest=1, notes={1: CONCEALED})
STATS = CallStats("call ended", 29.8, TRAFFIC, 50, 1280, 720, 24.0, (MediaBytes(300, 200, 0, 500),) * 4, 30.0, VOICE)
IDLE = "listening on 192.168.178.123:50005   code  correct-horse-battery 1234"
NOTE = "nothing can be sent to 192.168.178.123:50005 (Network is unreachable): check this machine's network"
SIGN = (("R", 754.0), ("D", 12.0))


def panels(size: tuple[int, int], callers: int, *, is_open: bool, help_open: bool) -> CallPanels:
    left = round(covered_width(size, 1.0)) if is_open and callers > 1 else 0
    cells = layout_grid(callers, size, left=left)
    names = [
        NamePlate(f"192.168.178.{i}:50005", Rect(x, size[1] - y - h, w, h), CONCEALED if i % 2 else "", i == 1)
        for i, (x, y, w, h) in enumerate(cells)
    ]
    return CallPanels(
        STATS, is_open, names if callers > 1 else (), (NOTE, IDLE), SIGN, help_lines() if help_open else ()
    )


@pytest.mark.parametrize("size", [(640, 480), (1280, 720), (1920, 1080)])
@pytest.mark.parametrize("help_open", [False, True])
@pytest.mark.parametrize("is_open", [False, True])
def test_no_panel_overlaps_another(size: tuple[int, int], is_open: bool, help_open: bool) -> None:
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        for callers in (1, 4, 9):
            shown = panels(size, callers, is_open=is_open, help_open=help_open)
            window.begin()
            with overlay.frame(window):
                layout = shown.layout(overlay)
                shown.draw(overlay)
            named = [name for name in layout.names if name is not None]
            rects = [layout.stats, layout.recording, *([layout.help] if help_open else []), *layout.messages, *named]
            found = [rect for rect in rects if rect is not None]
            assert len(found) == 4 + help_open + len(named)
            assert not [pair for pair in combinations(found, 2) if pair[0].overlaps(pair[1])]
            assert all(r.left >= 0 and r.top >= 0 and r.right <= size[0] and r.bottom <= size[1] for r in found)
            assert help_open or len(named) == (callers if callers > 1 else 0)
            painted = window.read().max(axis=2)
            for rect in found:
                painted[round(rect.top) - 1 : round(rect.bottom) + 1, round(rect.left) - 1 : round(rect.right) + 1] = 0
            assert not painted.any(), "something is drawn outside the rectangles"


def test_saved_images_show_open_statistics_and_names_but_no_other_panel() -> None:
    size = (640, 480)
    shown = panels(size, 4, is_open=True, help_open=True)
    images = []
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        for draw in (shown.draw_captured, shown.draw_others, replace(shown, is_open=False).draw_captured):
            window.begin()
            with overlay.frame(window):
                layout = shown.layout(overlay)
                draw(overlay)
            images.append(window.read().max(axis=2))
    captured, others, closed = images
    assert layout.help is not None and layout.recording is not None
    stats = np.s_[10:300, 10:100]
    assert captured[stats].any() and not others[stats].any() and not closed[stats].any()
    for rect in (layout.help, layout.recording, *layout.messages):
        inside = np.s_[round(rect.top) + 2 : round(rect.bottom) - 2, round(rect.left) + 2 : round(rect.right) - 2]
        assert others[inside].any() and not captured[inside].any()


def test_the_name_of_who_speaks_is_highlighted_and_a_note_about_a_voice_is_kept_in_a_narrow_cell() -> None:
    name, cells = "192.168.178.23:50005", [Rect(0, 0, 320, 240), Rect(320, 0, 320, 240), Rect(0, 240, 180, 240)]
    plates = [NamePlate(name, cells[0]), NamePlate(name, cells[1], "", True), NamePlate(name, cells[2], CONCEALED)]
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:
        shown = CallPanels(STATS, names=plates)
        window.begin((0.0, 0.0, 0.0, 1.0))
        with overlay.frame(window):
            layout = shown.layout(overlay)
            shown.draw(overlay)
            texts = [shown.shown_name(plate) for plate in plates]
        pixels = window.read().max(axis=2)
    brightness = []
    for rect in layout.names[:2]:
        assert rect is not None
        brightness.append(
            np.median(pixels[round(rect.top) : round(rect.bottom), round(rect.left) + 2 : round(rect.right) - 2])
        )
    assert brightness[0] < 60 and brightness[1] > 150
    assert texts[:2] == [name, name]
    assert texts[2].endswith(f"...  {CONCEALED}") and texts[2].startswith("1")
