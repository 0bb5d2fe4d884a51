"""A window in memory in which tests draw and click Dear ImGui panels."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from imgui_bundle import imgui

from conf.render.ui.imgui_input import ImGuiInput
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.ui.rectangle import Rect
from conf.render.ui.theme import column, themed
from conf.render.window.input_events import Event, MouseButton, MouseMoved
from conf.render.window.offscreen import OffscreenWindow

WIDGETS = (
    "button",
    "radio_button",
    "checkbox",
    "slider_float",
    "combo",
    "input_text",
    "input_text_with_hint",
    "selectable",
)


@pytest.fixture
def stage(gl: None) -> Iterator["Stage"]:
    """A window in memory of 400 x 900 pixels with an ImGui context."""
    with OffscreenWindow(400, 900) as window:
        stage = Stage(window)
        yield stage
        stage.overlay.release()


class Stage:
    """Draws ImGui widgets frame by frame and simulates input."""

    def __init__(self, window: OffscreenWindow) -> None:
        self.window = window
        self.overlay = ImGuiOverlay(window.ctx)
        self.rect = Rect(0, 0, 400, 900)
        self.input = ImGuiInput()

    def frame(self, draw: Callable[[], object]) -> None:
        """Draw one frame with `draw` inside a panel."""
        self.window.begin()
        with self.overlay.frame(self.window, scale=1.0), themed(1.0), column("test", self.rect):
            draw()

    def click(self, x: float, y: float, draw: Callable[[], None]) -> None:
        """Click at a position, drawing a frame after each event."""
        self.feed(MouseMoved(x, y), draw)
        for pressed in (True, False):
            self.feed(MouseButton(0, pressed, x, y), draw)
        self.frame(draw)

    def feed(self, event: Event, draw: Callable[[], None]) -> None:
        """Forward an event to ImGui and draw a frame."""
        self.input.process_events([event])
        self.frame(draw)

    def find(self, label: str, draw: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> tuple[float, float]:
        """Return the centre of the widget with this label."""
        return self.widgets(draw, monkeypatch)[label]

    def widgets(self, draw: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> dict[str, tuple[float, float]]:
        """Draw a frame. Returns the centre of each of its widgets by label."""
        found: dict[str, tuple[float, float]] = {}
        with monkeypatch.context() as patch:
            for name in WIDGETS:
                patch.setattr(imgui, name, _recording(getattr(imgui, name), found))
            self.frame(draw)
        return found


def _recording(original: Callable[..., Any], found: dict[str, tuple[float, float]]) -> Callable[..., Any]:
    def recording(label: str, *rest: Any, **more: Any) -> Any:
        result = original(label, *rest, **more)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        found[label] = ((low.x + high.x) / 2, (low.y + high.y) / 2)
        return result

    return recording
