import pytest

from conf.receiver.key_bindings import KEYS, action_of, apply_view_event, help_lines
from conf.render.camera import TOGGLES, ViewState
from conf.render.window.input_events import Dragged, KeyPressed, Scrolled


@pytest.mark.parametrize("toggle", TOGGLES)
def test_every_switch_of_the_view_has_a_key(toggle: str) -> None:
    key = next(key for key, (action, _) in KEYS.items() if action == toggle)
    assert apply_view_event(ViewState(), KeyPressed(key)) == ViewState().toggled(toggle)


def test_zero_and_home_reset_the_camera_and_keep_the_switches() -> None:
    moved = ViewState(yaw=1.0, zoom=3.0, points=True)
    for key in ("0", "home"):
        assert apply_view_event(moved, KeyPressed(key)) == ViewState(points=True)


@pytest.mark.parametrize("key", ["x", "space"])
def test_other_keys_do_not_change_the_view(key: str) -> None:
    assert apply_view_event(ViewState(), KeyPressed(key)) == ViewState()


def test_the_mouse_moves_the_camera() -> None:
    assert apply_view_event(ViewState(), Dragged("orbit", 0.5, 0.0)) == ViewState().orbited(0.5, 0.0)


def test_only_bound_keys_have_actions() -> None:
    assert action_of(KeyPressed("space")) == "pause"
    assert action_of(KeyPressed("q")) == action_of(KeyPressed("escape")) == "quit"
    assert action_of(KeyPressed("")) is None
    assert action_of(Scrolled(1.0)) is None


def test_the_help_lists_every_key_and_the_mouse() -> None:
    lines = dict(help_lines())
    assert lines["Space"] == "pause and go on"
    assert lines["Esc, Q"] == "quit"
    assert lines["drag"] == "turn the head"
    listed = {key for keys in lines for key in keys.split(", ")}
    assert len(listed) == len(KEYS) + 3
