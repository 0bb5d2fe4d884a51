"""A picture in memory on which Dear ImGui's panels are drawn and clicked."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from imgui_bundle import imgui

from conf.animator.gui.theme import column, themed
from conf.animator.picking import Rect
from conf.render.ui.imgui_input import ImGuiInput
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.input_events import Event, MouseButton, MouseMoved
from conf.render.window.offscreen import OffscreenWindow


@pytest.fixture
def stage(gl: None) -> Iterator["Stage"]:
    """A picture in memory that panels are drawn into and clicked on."""
    with OffscreenWindow(400, 900) as window:
        stage = Stage(window)
        yield stage
        stage.overlay.release()


class Stage:
    """Draws something with ImGui again and again, and clicks."""

    def __init__(self, window: OffscreenWindow) -> None:
        self.window = window
        self.overlay = ImGuiOverlay(window.ctx)
        self.rect = Rect(0, 0, 400, 900)
        self._hands = ImGuiInput()

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
        self._hands.process_events([event])
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
