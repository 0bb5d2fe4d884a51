import pytest

from conf.call.controls import (
    BUTTONS,
    CALL_KEYS,
    NO_MICROPHONE,
    PORTRAIT_OFF,
    PORTRAIT_ON,
    ButtonPlace,
    CallControls,
    LocalState,
)
from conf.receiver.panel_layout import Rect
from conf.render.window.input_events import Dragged, KeyPressed, MouseButton, MouseMoved, Scrolled


def test_a_call_begins_with_camera_and_microphone_and_without_images_of_the_person() -> None:
    assert LocalState() == LocalState(camera=True, microphone=True, portrait=False, has_microphone=True)


def test_a_face_is_shown_while_the_camera_is_on_and_works() -> None:
    assert LocalState().shows_face
    assert not LocalState(camera=False).shows_face and not LocalState(camera_fault="gone").shows_face


class Stage:
    """Controls with a button of 10 pixels for each action, side by side."""

    def __init__(self, state: LocalState | None = None) -> None:
        self.state = state or LocalState()
        self.controls = CallControls(self.state)
        self.controls.buttons = [ButtonPlace(action, Rect(10 * i, 0, 10, 10)) for i, action in enumerate(BUTTONS)]
        self.toasts: list[str] = []
        self.actions: list[str] = []
        self.controls.show_toast = lambda text, now: self.toasts.append(text)
        self.controls.run_action = lambda action, now: self.actions.append(action)

    def press(self, key: str) -> bool:
        return self.controls.intercept(KeyPressed(key), 0.0)

    def click(self, action: str) -> bool:
        x = 10.0 * BUTTONS.index(action) + 5
        taken = self.controls.intercept(MouseButton(0, True, x, 5.0), 0.0)
        self.controls.intercept(MouseButton(0, False, x, 5.0), 0.0)
        return taken


@pytest.mark.parametrize("way", ["key", "button"])
def test_keys_and_buttons_change_one_s_own_end(way: str) -> None:
    stage = Stage()

    def use(key: str, action: str) -> bool:
        return stage.press(key) if way == "key" else stage.click(action)

    assert use("m", "microphone") and not stage.state.microphone
    assert use("m", "microphone") and stage.state.microphone
    assert use("c", "camera") and not stage.state.camera
    assert use("p", "own portrait") and stage.state.portrait
    assert use("p", "own portrait") and not stage.state.portrait
    assert stage.toasts == [PORTRAIT_ON, PORTRAIT_OFF] and stage.actions == []


def test_buttons_of_the_viewer_are_passed_on_and_its_keys_left_alone() -> None:
    stage = Stage()
    assert stage.click("record video") and stage.click("quit")
    assert stage.actions == ["record video", "quit"]
    assert not stage.press("r") and not stage.press("escape") and not stage.press("x")


def test_one_s_own_corner_shows_what_the_other_sees() -> None:
    stage = Stage()
    assert stage.press("o") and stage.controls.sees_sent
    assert stage.press("o") and not stage.controls.sees_sent


def test_without_a_microphone_it_is_said_so() -> None:
    stage = Stage(LocalState(has_microphone=False))
    assert stage.press("m") and stage.state.microphone and stage.toasts == [NO_MICROPHONE]


def test_the_button_under_the_mouse_is_known() -> None:
    stage = Stage()
    assert not stage.controls.intercept(MouseMoved(15.0, 5.0), 0.0) and stage.controls.hovered == "camera"
    stage.controls.intercept(MouseMoved(15.0, 15.0), 0.0)
    assert stage.controls.hovered is None


def test_a_drag_from_a_button_turns_no_head_and_any_other_does() -> None:
    controls = Stage().controls
    drag = Dragged("orbit", 0.1, 0.0)
    controls.intercept(MouseButton(0, True, 5.0, 5.0), 0.0)
    assert controls.intercept(drag, 0.0)
    controls.intercept(MouseButton(0, False, 5.0, 50.0), 0.0)
    assert not controls.intercept(drag, 0.0) and not controls.intercept(Scrolled(1.0), 0.0)
    assert not controls.intercept(MouseButton(0, True, 5.0, 50.0), 0.0)
    assert not controls.intercept(MouseButton(1, True, 5.0, 5.0), 0.0)


def test_every_button_has_a_key() -> None:
    assert set(BUTTONS) <= {action for action, _ in CALL_KEYS.values()}


def test_a_camera_that_is_missing_is_said_when_it_is_switched_on() -> None:
    stage = Stage(LocalState(camera_fault="there is no camera 0"))
    assert stage.press("c") and not stage.state.camera and stage.toasts == []
    assert stage.press("c") and stage.state.camera and stage.toasts == ["there is no camera 0"]
