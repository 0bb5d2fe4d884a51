from collections.abc import Iterator

import pytest

from conf.animator.controller import Director
from conf.animator.face_document import Subject
from conf.animator.face_instance import Actor
from conf.animator.gui.layout import Layout
from conf.animator.viewport_controller import Touch
from conf.face.deformation.face_model import Deformer
from conf.render.window.input_events import Dragged, Event, KeyPressed, MouseButton, MouseMoved, Scrolled
from tests.support.imgui_stage import Stage

LAYOUT = Layout.of((1280, 800), 1.0)


@pytest.fixture
def director(stage: Stage, subject: Subject) -> Iterator[Director]:
    director = Director(stage.window.ctx, Actor(stage.window.ctx, subject, Deformer()))
    stage.frame(lambda: None)
    yield director
    director.release()


def take(touch: Touch, *events: Event) -> None:
    touch.take(list(events), LAYOUT, 1.0, 0.0)


def test_a_drag_over_the_face_turns_it_one_over_a_panel_does_not(director: Director) -> None:
    touch = Touch(director)
    take(touch, MouseButton(0, True, 100, 300), Dragged("turn", 0.2, 0.0), MouseButton(0, False, 120, 300))
    assert director.desk.look.view.yaw == 0
    take(touch, MouseButton(0, True, 640, 300), Dragged("turn", 0.2, 0.0), MouseButton(0, False, 700, 300))
    assert director.desk.look.view.yaw > 0


def test_the_wheel_zooms_over_the_face_only(director: Director) -> None:
    touch = Touch(director)
    take(touch, MouseMoved(1200, 300), Scrolled(2.0))
    assert director.desk.look.view.zoom == 1
    take(touch, MouseMoved(640, 300), Scrolled(2.0))
    assert director.desk.look.view.zoom > 1


def test_keys(director: Director) -> None:
    touch = Touch(director)
    take(touch, KeyPressed("w"), KeyPressed("p"), KeyPressed("e"))
    assert director.desk.look.style == "wireframe"
    assert director.desk.look.view.points and director.desk.look.eye_contact
    take(touch, KeyPressed("h"), KeyPressed("escape"))
    assert not director.desk.help
    assert touch.take([KeyPressed("escape")], LAYOUT, 1.0, 0.0).quit
    assert touch.take([KeyPressed("s"), KeyPressed("r")], LAYOUT, 1.0, 0.0).picture
