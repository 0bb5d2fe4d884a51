import pytest

from conf.render.camera import TOGGLES, ViewState
from conf.render.window.input_events import (
    KEYS,
    Dragged,
    Event,
    KeyPressed,
    Resized,
    Scrolled,
    action_of,
    apply_camera_event,
)


@pytest.mark.parametrize("toggle", TOGGLES)
def test_every_toggle_has_a_key(toggle: str) -> None:
    key = next(key for key, (action, _) in KEYS.items() if action == toggle)
    assert apply_camera_event(ViewState(), KeyPressed(key)) == ViewState().toggled(toggle)


@pytest.mark.parametrize(
    ("event", "view"),
    [
        (Dragged("turn", 0.5, 0.0), ViewState().turned(0.5, 0.0)),
        (Dragged("pan", 0.1, -0.2), ViewState(pan=(0.1, -0.2))),
        (Scrolled(2.0), ViewState().zoomed(2.0)),
        (Resized(10, 10), ViewState()),
        (KeyPressed("home"), ViewState()),
        (KeyPressed("x"), ViewState()),
        (KeyPressed("space"), ViewState()),
    ],
)
def test_what_an_event_does_to_the_view(event: Event, view: ViewState) -> None:
    assert apply_camera_event(ViewState(), event) == view


def test_zero_and_home_look_straight_again() -> None:
    turned = ViewState(yaw=1.0, zoom=3.0, points=True)
    assert (
        apply_camera_event(turned, KeyPressed("0"))
        == apply_camera_event(turned, KeyPressed("home"))
        == ViewState(points=True)
    )


def test_only_keys_ask_for_actions() -> None:
    assert action_of(KeyPressed("space")) == "pause"
    assert action_of(KeyPressed("q")) == action_of(KeyPressed("escape")) == "quit"
    assert action_of(KeyPressed("")) is None
    assert action_of(Scrolled(1.0)) is None
