"""All pages, drawn at several sizes: every control is inside of the window."""

from collections.abc import Iterator
from datetime import UTC, datetime

import pytest
from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.ui.theme import themed
from conf.render.window.offscreen import OffscreenWindow
from conf.start.gui.layout import SCALE, Layout
from conf.start.gui.main import StartGui
from conf.start.recent_calls import RecentCall
from tests.start.conftest import Stand
from tests.support.imgui_stage import WIDGETS

NOW = datetime(2026, 3, 2, 12, 0, tzinfo=UTC)
SIZES = [(800, 600), (1000, 700), (1280, 720), (1920, 1080)]


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def window(request: pytest.FixtureRequest, gl: None) -> Iterator[OffscreenWindow]:
    with OffscreenWindow(*request.param) as window:
        yield window


def labels_outside(window: OffscreenWindow, stand: Stand, monkeypatch: pytest.MonkeyPatch) -> tuple[int, list[str]]:
    """Draw two frames. Returns the number of controls, and the labels of those that are not wholly in the window."""
    rects: dict[str, tuple[float, float, float, float]] = {}

    def recording(original):  # type: ignore[no-untyped-def]
        def record(label, *rest, **more):  # type: ignore[no-untyped-def]
            result = original(label, *rest, **more)
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            rects[label] = (low.x, low.y, high.x, high.y)
            return result

        return record

    with monkeypatch.context() as patch, ImGuiOverlay(window.ctx) as overlay, StartGui(window.ctx, overlay) as gui:
        for name in WIDGETS:
            patch.setattr(imgui, name, recording(getattr(imgui, name)))
        scale = SCALE.scale(window.size, 1.0)
        for _ in range(2):
            gui.prepare(stand.controller)
            window.begin()
            with overlay.frame(window, scale=scale), themed(scale):
                gui.draw(stand.controller, Layout.of(window.size, scale), 0.0, NOW)
    width, height = window.size
    outside = [
        label
        for label, (left, top, right, bottom) in rects.items()
        if left < 0 or top < 0 or right > width or bottom > height
    ]
    return len(rects), outside


def test_every_control_of_the_first_page_fits(
    window: OffscreenWindow, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand.controller.recent = tuple(RecentCall(f"host{number}", NOW, "Anna") for number in range(3))
    stand.controller.call()  # with errors below address and code
    count, outside = labels_outside(window, stand, monkeypatch)
    assert count >= 16 and outside == []


def test_every_control_of_the_waiting_page_fits(
    window: OffscreenWindow, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand.controller.wait_at_port()
    stand.controller.addresses = tuple(f"2001:db8:85a3:8d3:1319:8a2e:370:{number}" for number in range(3))
    count, outside = labels_outside(window, stand, monkeypatch)
    assert count == 5 and outside == []
