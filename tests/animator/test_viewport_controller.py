from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.controller import Controller
from conf.animator.gui.layout import Layout
from conf.animator.motion_player import REST_POSE
from conf.animator.viewport_controller import ViewportController, WindowCommand
from conf.face.formats.dpc import MotionClip
from conf.render.camera import clip_matrix
from conf.render.window.input_events import (
    Dragged,
    Event,
    KeyPressed,
    KeyStateChanged,
    MouseButton,
    MouseMoved,
    Scrolled,
)
from tests.animator.conftest import NOW
from tests.support.imgui_stage import Stage

pytestmark = pytest.mark.slow

LAYOUT = Layout.of((1280, 800), 1.0)


class Viewport:
    """A viewport controller that is sent events."""

    def __init__(self, controller: Controller) -> None:
        self._viewport = ViewportController(controller)

    def send(self, *events: Event) -> set[WindowCommand]:
        return self._viewport.process_events(list(events), LAYOUT, 1.0, NOW)

    def click(self, x: float, y: float) -> None:
        self.send(MouseButton(0, True, x, y), MouseButton(0, False, x, y))


@pytest.fixture
def viewport(stage: Stage, controller: Controller) -> Viewport:
    stage.frame(lambda: None)
    return Viewport(controller)


def test_a_drag_over_the_face_turns_it_and_over_a_panel_does_not(viewport: Viewport, controller: Controller) -> None:
    viewport.send(MouseButton(0, True, 100, 300), Dragged("orbit", 0.2, 0.0), MouseButton(0, False, 120, 300))
    assert controller.state.view.camera.yaw == 0
    viewport.send(MouseButton(0, True, 640, 300), Dragged("orbit", 0.2, 0.0), MouseButton(0, False, 700, 300))
    assert controller.state.view.camera.yaw > 0


def test_the_wheel_zooms_over_the_face_only(viewport: Viewport, controller: Controller) -> None:
    viewport.send(MouseMoved(1200, 300), Scrolled(2.0))
    assert controller.state.view.camera.zoom == 1
    viewport.send(MouseMoved(640, 300), Scrolled(2.0))
    assert controller.state.view.camera.zoom > 1


def test_keys_switch_style_points_eye_contact_and_help(viewport: Viewport, controller: Controller) -> None:
    assert viewport.send(KeyPressed("w"), KeyPressed("p"), KeyPressed("e")) == set()
    view = controller.state.view
    assert view.style == "wireframe" and view.camera.points and view.eye_contact
    viewport.send(KeyPressed("w"), KeyPressed("h"))
    assert controller.state.view.style == "rendered" and controller.state.show_help
    assert viewport.send(KeyPressed("escape")) == set()
    assert not controller.state.show_help


def test_window_commands_are_returned(viewport: Viewport) -> None:
    assert viewport.send(KeyPressed("s"), KeyPressed("r")) == {"screenshot", "record"}
    assert viewport.send(KeyPressed("f")) == {"full screen"}
    assert viewport.send(KeyPressed("escape")) == viewport.send(KeyPressed("q")) == {"quit"}


def test_space_and_arrows_work_the_player_or_repeat_the_expression(viewport: Viewport, controller: Controller) -> None:
    viewport.send(KeyPressed("space"), KeyStateChanged("left_arrow", True))
    assert not controller.state.expression.running
    controller.play_expression("joy", 0.0)
    viewport.send(KeyPressed("space"))
    assert [e.name for e in controller.state.expression.running] == ["joy", "joy"]
    controller.play_clip("a", MotionClip(10.0, "fapu", np.zeros((21, 50, 3), np.float32)), NOW)
    assert controller.player is not None
    viewport.send(KeyPressed("space"))
    assert not controller.player.is_playing(NOW)
    viewport.send(KeyStateChanged("right_arrow", True), KeyStateChanged("right_arrow", False))
    assert controller.player.frame(NOW) == 1


def test_clicks_place_points_ctrl_z_undoes_and_escape_cancels(
    viewport: Viewport, controller: Controller, points: np.ndarray
) -> None:
    controller.place_points()
    clip = clip_matrix(REST_POSE, controller.state.view.camera, aspect=LAYOUT.face.width / LAYOUT.face.height)
    x, y = LAYOUT.face.to_pixels(points[[0]], clip)[0]
    viewport.click(x + 8, y)
    assert controller.state.placement is not None
    moved = controller.state.placement.points[0] - points[0]
    assert 0.05 < np.linalg.norm(moved) < 1.0
    viewport.click(LAYOUT.face.x + 2, LAYOUT.face.y + 2)
    assert len(controller.state.placement.history) == 1, "beside the face nothing is placed"
    viewport.send(KeyStateChanged("left_ctrl", True), KeyPressed("z"))
    np.testing.assert_array_equal(controller.state.placement.points, points)
    assert viewport.send(KeyPressed("escape")) == set()
    assert controller.state.placement is None


def test_a_key_that_can_do_nothing_says_why(viewport: Viewport, controller: Controller, unplaced_mesh: Path) -> None:
    for key, notice in (("space", "nothing to play"), ("z", "works while control points are placed")):
        viewport.send(KeyStateChanged("left_ctrl", key == "z"), KeyPressed(key))
        assert notice in controller.notice
    viewport.send(KeyStateChanged("left_ctrl", False), KeyStateChanged("right_arrow", True))
    assert "no recording to step through" in controller.notice
    viewport.send(KeyPressed("g"), KeyPressed("p"))
    assert controller.notice == "regions hide the control points: G shows the face again"
    viewport.send(KeyPressed("g"))
    controller.open_file(unplaced_mesh, NOW)
    for key in ("p", "g"):
        controller.notice = ""
        viewport.send(KeyPressed(key))
        assert controller.notice.startswith("this face has no control points yet: Find points or Place points")
    viewport.send(KeyPressed("e"), KeyPressed("e"))
    assert controller.notice == "this face has no eyeballs that could turn to you"
    controller.notice = ""
    viewport.send(KeyPressed("w"))
    assert controller.state.view.style == "wireframe" and controller.notice == ""


def test_quitting_while_points_are_placed_asks_first(viewport: Viewport, controller: Controller) -> None:
    assert controller.request_quit()
    controller.place_points()
    assert controller.request_quit(), "nothing is placed yet"
    assert controller.state.placement is not None
    controller.state = replace(controller.state, placement=controller.state.placement.push_undo())
    assert viewport.send(KeyPressed("q")) == {"quit"} and not controller.request_quit()
    assert controller.state.question == "quit"
    viewport.send(KeyPressed("w"))
    assert controller.state.view.style == "rendered", "other keys wait for the answer"
    assert viewport.send(KeyPressed("escape")) == set()
    assert controller.state.question is None and controller.state.placement is not None
    assert not controller.request_quit()
    assert viewport.send(KeyPressed("q")) == {"quit"} and controller.request_quit(), "Q again means it"
    controller.state = replace(controller.state, question=None)
    viewport.send(KeyPressed("escape"))
    assert controller.state.question == "cancel" and controller.state.placement is not None
