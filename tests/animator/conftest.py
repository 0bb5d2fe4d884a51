"""The shipped head as a subject, and a mesh file that nobody knows the control points of."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui

from conf.animator.builder import FaceBuilder
from conf.animator.desk import Desk, Facts
from conf.animator.hands import Hands
from conf.animator.interface import Panel
from conf.animator.obj_file import write_obj
from conf.animator.picking import Rect
from conf.animator.requests import Request
from conf.animator.subject import Subject, open_subject
from conf.animator.theme import column, themed
from conf.errors import GraphicsError
from conf.face.action_units import load_emotions
from conf.face.head import Deformer, FaceModel
from conf.receiver.events import Event, MouseButton, MouseMoved
from conf.receiver.offscreen import OffscreenWindow
from conf.receiver.overlay import Overlay

TO_FILE = (25.0, np.array([3.0, 1500.0, -8.0]))  # scale and shift of the stranger's file


@pytest.fixture(scope="session")
def subject() -> Subject:
    """The shipped head."""
    return open_subject()


@pytest.fixture(scope="session")
def head(subject: Subject) -> FaceModel:
    """The shipped head's model."""
    return FaceBuilder(subject).build(Deformer())


@pytest.fixture(scope="session")
def stranger(subject: Subject, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped head as a mesh file of another unit, without control points."""
    path = tmp_path_factory.mktemp("stranger") / "stranger.obj"
    scale, shift = TO_FILE
    write_obj(path, subject.mesh, subject.mesh.vertices * scale + shift)
    return path


@pytest.fixture
def stage() -> Iterator["Stage"]:
    """A picture in memory that panels are drawn into and clicked on."""
    try:
        window = OffscreenWindow(400, 900)
    except GraphicsError as error:
        if os.environ.get("CONF_REQUIRE_GL"):
            raise
        pytest.skip(str(error))
    with window:
        stage = Stage(window)
        yield stage
        stage.overlay.release()


class Stage:
    """Draws something with ImGui again and again, and clicks."""

    def __init__(self, window: OffscreenWindow) -> None:
        self.window = window
        self.overlay = Overlay(window.ctx)
        self.rect = Rect(0, 0, 400, 900)
        self._hands = Hands()

    def frame(self, draw: Callable[[], None]) -> None:
        """Draw one frame of a panel."""
        self.window.begin()
        with (
            self.overlay.frame(self.window.framebuffer, self.window.size, 1.0, scale=1.0),
            themed(1.0),
            column("test", self.rect),
        ):
            draw()

    def click(self, x: float, y: float, draw: Callable[[], None]) -> None:
        """Click on a place, drawing meanwhile."""
        self.feed(MouseMoved(x, y), draw)
        for pressed in (True, False):
            self.feed(MouseButton(0, pressed, x, y), draw)
        self.frame(draw)

    def feed(self, event: Event, draw: Callable[[], None]) -> None:
        """Let ImGui know of an event, and draw."""
        self._hands.feed([event])
        self.frame(draw)

    def find(self, label: str, draw: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> tuple[float, float]:
        """Return the middle of a widget, by its label."""
        found: dict[str, tuple[float, float]] = {}
        with monkeypatch.context() as patch:
            for name in ("button", "radio_button", "checkbox", "slider_float", "combo"):
                patch.setattr(imgui, name, _noting(getattr(imgui, name), found))
            self.frame(draw)
        return found[label]


def _noting(original: Callable[..., Any], found: dict[str, tuple[float, float]]) -> Callable[..., Any]:
    def noting(label: str, *rest: Any, **more: Any) -> Any:
        answer = original(label, *rest, **more)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        found[label] = ((low.x + high.x) / 2, (low.y + high.y) / 2)
        return answer

    return noting


class Worked:
    """A panel with the desk it works on: click its widgets by their labels."""

    def __init__(self, stage: Stage, panel: Panel, facts: Facts, monkeypatch: pytest.MonkeyPatch) -> None:
        self.desk, self.facts, self.requests = Desk(), facts, list[Request]()
        self._stage, self._panel, self._monkeypatch = stage, panel, monkeypatch
        self._draw()

    def _draw(self) -> None:
        self._stage.frame(self._once)

    def _once(self) -> None:
        self.desk, asked = self._panel(self.desk, self.facts)
        self.requests += asked

    def press(self, label: str) -> None:
        """Click in the middle of a widget."""
        place = self._stage.find(label, self._once, self._monkeypatch)
        self._stage.click(*place, self._once)


@pytest.fixture
def facts(subject: Subject) -> Facts:
    """What panels are told of the shipped head."""
    return Facts(1.0, subject, None, load_emotions(), vertices=len(subject.mesh.vertices))


@pytest.fixture
def work(stage: Stage, facts: Facts, monkeypatch: pytest.MonkeyPatch) -> Callable[[Panel], Worked]:
    """Open a panel to work on."""
    return lambda panel: Worked(stage, panel, facts, monkeypatch)
