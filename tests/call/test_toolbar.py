import pytest

from conf.call.controls import BUTTONS, LocalState
from conf.call.toolbar import buttons_of, draw_toolbar, lay_out_buttons, toolbar_sizes
from conf.receiver.panel_layout import Rect
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow


def test_the_buttons_say_what_a_click_changes_or_what_is_off() -> None:
    buttons = buttons_of(LocalState(), is_recording=False, in_call=True)
    assert [button.action for button in buttons] == list(BUTTONS)
    assert [button.text for button in buttons] == ["mute", "camera off", "portrait on", "record", "hang up"]
    assert [button.key for button in buttons] == ["M", "C", "P", "R", "Esc"]
    assert not any(button.is_warning or button.is_active for button in buttons)
    off = LocalState(camera=False, microphone=False, portrait=True)
    changed = buttons_of(off, is_recording=True, in_call=False)
    assert [b.text for b in changed] == ["muted", "camera is off", "portrait is on", "stop recording", "leave"]
    assert [b.is_warning for b in changed] == [True, True, False, False, False]
    assert [b.is_active for b in changed] == [False, False, True, True, False]
    assert buttons_of(LocalState(has_microphone=False), is_recording=False, in_call=True)[0].text == "no microphone"
    missing = buttons_of(LocalState(camera_fault="there is no camera 0"), is_recording=False, in_call=True)[1]
    assert missing.text == "no camera" and missing.is_warning


@pytest.mark.slow
def test_the_buttons_are_drawn_where_they_are_clicked(gl: None) -> None:
    buttons = buttons_of(LocalState(camera=False), is_recording=True, in_call=True)
    images = {}
    with OffscreenWindow(700, 100) as window, ImGuiOverlay(window.ctx) as overlay:
        for hovered in (None, "microphone", "quit"):
            window.begin()
            with overlay.frame(window, scale=0.8):
                size, sizes = toolbar_sizes(buttons, 0.8)
                places = lay_out_buttons(Rect(4.0, 6.0, *size), sizes, 0.8)
                draw_toolbar(overlay, buttons, places, hovered=hovered)
            images[hovered] = window.read().astype(int)
    assert places[0].left == 4.0 and places[-1].right == pytest.approx(4.0 + size[0])
    painted = images[None].max(axis=2)
    for button, place in zip(buttons, places, strict=True):
        inside = painted[round(place.top) + 2 : round(place.bottom) - 2, round(place.left) + 4 : round(place.right) - 4]
        assert inside.min() > 0, button.text
        painted[round(place.top) - 1 : round(place.bottom) + 1, round(place.left) - 1 : round(place.right) + 1] = 0
    assert not painted.any()
    for action in ("microphone", "quit"):
        differing = (images[action] != images[None]).any(axis=2).nonzero()
        place = places[BUTTONS.index(action)]
        assert len(differing[0]) and place.left - 1 <= differing[1].min() and differing[1].max() <= place.right + 1
