import pytest

from conf.render.camera import ViewState
from conf.render.window.input_events import Dragged, Event, KeyPressed, Scrolled, apply_camera_event


@pytest.mark.parametrize(
    ("event", "view"),
    [
        (Dragged("orbit", 0.5, 0.0), ViewState().orbited(0.5, 0.0)),
        (Dragged("pan", 0.1, -0.2), ViewState(pan=(0.1, -0.2))),
        (Scrolled(2.0), ViewState().zoomed(2.0)),
        (KeyPressed("home"), ViewState()),
    ],
)
def test_the_mouse_orbits_pans_and_zooms(event: Event, view: ViewState) -> None:
    assert apply_camera_event(ViewState(), event) == view
