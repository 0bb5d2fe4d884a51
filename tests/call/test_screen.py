from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from conf.call.controls import BUTTONS, CALL_KEYS, LocalState
from conf.call.link_state import LinkState, Quality
from conf.call.screen import CallScreen
from conf.call.self_picture import SelfPicture
from conf.call.self_view import SelfView
from conf.call.toolbar import buttons_of
from conf.call.view import Notice, status_parts
from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.receiver.call_stats import CallStats
from conf.receiver.viewer_controls import help_lines
from conf.receiver.voice.voice_status import VoiceStatus
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

pytestmark = pytest.mark.slow

TRAFFIC = TrafficSnapshot(123456, 345, 123, 1300, 0, 29.8, 48.2, 443.7, 230400, 27648.0, 4783.0, 4.12, 67.0)
STATS = CallStats("receiving", 29.8, TRAFFIC, 50, 1280, 720, 24.0, (MediaBytes(300, 200, 0, 500),) * 4, 30.0)
LINK = LinkState(Quality.WEAK, "uneven delay, 412 ms")
NAME = "Annemarie Müller-Lüdenscheidt"
NAME_NOTE = "no face seen  no room for voice  portrait 40 %"
NOTE = "nothing can be sent to 192.168.178.123:50005 (Network is unreachable): check this machine's network"
FULL = CallScreen(
    status=status_parts(LINK, "Annemarie Müller-Lüdenscheidt", 3723.0, replace(STATS, voice=VoiceStatus(-20.0))),
    stats=STATS,
    name=NAME,
    name_note=NAME_NOTE,
    own_aspect=4 / 3,
    own_caption="what is seen of you  no face seen  muted",
    messages=(NOTE, "saved conf.mp4"),
    buttons=buttons_of(LocalState(camera=False, microphone=False), is_recording=True, in_call=True),
    recordings=(("R", 754.0), ("D", 12.0)),
)


@pytest.mark.parametrize("size", [(640, 480), (1280, 720), (1920, 1080), (320, 240)])
@pytest.mark.parametrize("what", ["call", "help", "waiting"])
def test_nothing_is_drawn_outside_of_rectangles_that_do_not_overlap(gl: None, size: tuple[int, int], what: str) -> None:
    screen = {
        "call": FULL,
        "help": replace(FULL, help=help_lines(CALL_KEYS)),
        "waiting": replace(FULL, stats=None, name="", notice=Notice("waiting", "acorn-tulip-river-42", (NOTE[:60],))),
    }[what]
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        picture = SelfPicture(window.ctx, SelfView())
        window.begin()
        with overlay.frame(window):
            layout = screen.layout(overlay)
            screen.draw_captured(overlay, layout)
            places = screen.draw_others(overlay, layout, picture, is_own_drawn=False, hovered=None)
        painted = window.read().max(axis=2)
        picture.release()
    single = (layout.status, layout.toolbar, layout.stats, layout.notice, layout.recording, layout.help, layout.own)
    found = [rect for rect in (*single, layout.name, *layout.messages) if rect is not None]
    assert not [pair for pair in combinations(found, 2) if pair[0].overlaps(pair[1])]
    assert [place.action for place in places] == [*BUTTONS[: 5 if size[0] >= 640 else 3], "quit"][:5]
    assert layout.status
    assert size[0] < 1000 or (layout.own and layout.recording and (layout.help is None) == (what != "help"))
    assert size[0] < 1000 or (layout.notice is None) == (what != "waiting")
    for rect in found:
        painted[round(rect.top) - 1 : round(rect.bottom) + 1, round(rect.left) - 1 : round(rect.right) + 1] = 0
    assert not painted.any(), "something is drawn outside the rectangles"


def test_saved_images_show_who_it_is_and_nothing_else(gl: None) -> None:
    with OffscreenWindow(1280, 720) as window, ImGuiOverlay(window.ctx) as overlay:
        window.begin()
        with overlay.frame(window):
            layout = FULL.layout(overlay)
            FULL.draw_captured(overlay, layout)
        painted = window.read().max(axis=2)
    rect = layout.name
    assert rect and np.count_nonzero(painted) > 500
    painted[round(rect.top) - 1 : round(rect.bottom) + 1, round(rect.left) - 1 : round(rect.right) + 1] = 0
    assert not painted.any()


def test_keys_are_left_out_of_buttons_that_would_not_fit(gl: None) -> None:
    widths = []
    for width in (1280, 480):
        with OffscreenWindow(width, 400) as window, ImGuiOverlay(window.ctx) as overlay:
            with overlay.frame(window, scale=1.0):
                toolbar = FULL.layout(overlay).toolbar
                assert toolbar
                widths.append(toolbar.width)
    assert widths[1] < widths[0]


def test_in_a_tiny_window_one_can_still_leave(gl: None) -> None:
    with OffscreenWindow(90, 90) as window, ImGuiOverlay(window.ctx) as overlay, overlay.frame(window):
        assert [button.action for button in FULL._fitting_buttons(overlay)] == ["quit"]


def test_what_is_to_be_known_of_the_other_is_kept_beside_a_long_name(gl: None) -> None:
    with OffscreenWindow(480, 400) as window, ImGuiOverlay(window.ctx) as overlay, overlay.frame(window):
        assert (
            replace(FULL, name=2 * NAME, name_note="portrait 40 %")._shown_name(overlay).endswith("...  portrait 40 %")
        )
        assert replace(FULL, name="Bob", name_note="")._shown_name(overlay) == "Bob"
