from collections.abc import Iterator

import pytest

from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance
from conf.animator.gui.layout import Layout
from conf.animator.viewport_controller import ViewportController
from conf.face.deformation.face_model import DeformerOptions
from conf.render.window.input_events import Dragged, Event, KeyPressed, MouseButton, MouseMoved, Scrolled
from tests.support.imgui_stage import Stage

LAYOUT = Layout.of((1280, 800), 1.0)


@pytest.fixture
def director(stage: Stage, subject: FaceDocument) -> Iterator[Controller]:
    director = Controller(stage.window.ctx, FaceInstance(stage.window.ctx, subject, DeformerOptions()))
    stage.frame(lambda: None)
    yield director
    director.release()


def take(touch: ViewportController, *events: Event) -> None:
    touch.process_events(list(events), LAYOUT, 1.0, 0.0)


def test_a_drag_over_the_face_turns_it_one_over_a_panel_does_not(director: Controller) -> None:
    touch = ViewportController(director)
    take(touch, MouseButton(0, True, 100, 300), Dragged("orbit", 0.2, 0.0), MouseButton(0, False, 120, 300))
    assert director.desk.look.view.yaw == 0
    take(touch, MouseButton(0, True, 640, 300), Dragged("orbit", 0.2, 0.0), MouseButton(0, False, 700, 300))
    assert director.desk.look.view.yaw > 0


def test_the_wheel_zooms_over_the_face_only(director: Controller) -> None:
    touch = ViewportController(director)
    take(touch, MouseMoved(1200, 300), Scrolled(2.0))
    assert director.desk.look.view.zoom == 1
    take(touch, MouseMoved(640, 300), Scrolled(2.0))
    assert director.desk.look.view.zoom > 1


def test_keys(director: Controller) -> None:
    touch = ViewportController(director)
    take(touch, KeyPressed("w"), KeyPressed("p"), KeyPressed("e"))
    assert director.desk.look.style == "wireframe"
    assert director.desk.look.view.points and director.desk.look.eye_contact
    take(touch, KeyPressed("h"), KeyPressed("escape"))
    assert not director.desk.help
    assert touch.process_events([KeyPressed("escape")], LAYOUT, 1.0, 0.0).quit
    assert touch.process_events([KeyPressed("s"), KeyPressed("r")], LAYOUT, 1.0, 0.0).picture
