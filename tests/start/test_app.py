"""The window's loop: pages, Escape, the clipboard, and hiding during a call."""

from collections.abc import Iterator

import pytest

from conf.render.window.input_events import Event, KeyPressed, KeyStateChanged, MouseButton, MouseMoved, TextInput
from conf.render.window.offscreen import OffscreenWindow
from conf.start.app import StartApp
from conf.start.gui.waiting_panel import WaitingPanel
from conf.start.state import CallTarget
from tests.start.conftest import Stand


class ScriptedWindow(OffscreenWindow):
    """A window in memory with the events that a test gives."""

    def __init__(self) -> None:
        super().__init__(800, 600)
        self.events: list[Event] = []
        self.drawn = 0

    def poll(self) -> list[Event]:
        events, self.events = self.events, []
        return events

    def end(self) -> None:
        self.drawn += 1


@pytest.fixture
def window(gl: None) -> Iterator[ScriptedWindow]:
    with ScriptedWindow() as window:
        yield window


@pytest.fixture
def app(window: ScriptedWindow, stand: Stand) -> Iterator[StartApp]:
    app = StartApp(window, stand.controller)
    yield app
    app.close()


def test_escape_ends_waiting_and_then_closes_the_window(app: StartApp, window: ScriptedWindow, stand: Stand) -> None:
    app.step(0.0)
    stand.controller.wait_at_port()
    window.events = [KeyPressed("escape")]
    app.step(0.1)
    assert stand.calls[0].hung_up == 1 and not window.should_close
    stand.calls[0].is_running = False
    app.step(0.2)
    window.events = [KeyPressed("escape")]
    app.step(0.3)
    assert window.should_close and not window.close_on_escape


def press(app: StartApp, window: ScriptedWindow, key: str) -> None:
    """Press and release a key; ImGui needs some frames for it."""
    window.events = [KeyStateChanged(key, True)]
    app.step(0.0)
    window.events = [KeyStateChanged(key, False)]
    for _ in range(3):
        app.step(0.0)


@pytest.mark.slow
def test_all_pages_are_operated_by_keys_alone(app: StartApp, window: ScriptedWindow, stand: Stand) -> None:
    for _ in range(3):
        app.step(0.0)
    for text in ("acorn tulip river 42", "host"):
        press(app, window, "tab")
        window.events = [TextInput(text)]
        app.step(0.0)
    press(app, window, "tab")
    press(app, window, "enter")  # Call
    assert stand.calls[0].target == CallTarget("host", 5005, "acorn-tulip-river-42")
    press(app, window, "enter")  # Cancel
    assert stand.calls[0].hung_up == 1
    stand.calls[0].is_running = False
    for _ in range(3):
        app.step(0.0)
    for _ in range(4):  # from the code to the port
        press(app, window, "tab")
    press(app, window, "enter")
    assert stand.controller.state.page == "waiting" and stand.controller.state.target is not None
    press(app, window, "enter")
    assert window.clipboard == stand.controller.state.target.code
    press(app, window, "tab")
    press(app, window, "enter")
    assert window.clipboard == "192.0.2.2"
    for _ in range(2):
        press(app, window, "tab")
    press(app, window, "enter")
    assert stand.calls[1].hung_up == 1


def test_escape_clears_errors_first(app: StartApp, window: ScriptedWindow, stand: Stand) -> None:
    stand.controller.call()
    for expected in (False, True):
        window.events = [KeyPressed("escape")]
        app.step(0.0)
        assert not stand.controller.state.complains and window.should_close is expected


def test_escape_in_a_field_does_not_close_the_window(app: StartApp, window: ScriptedWindow) -> None:
    app.step(0.0)
    for event in MouseMoved(200.0, 85.0), MouseButton(0, True, 200.0, 85.0), MouseButton(0, False, 200.0, 85.0):
        window.events = [event]
        app.step(0.1)
    window.events = [KeyPressed("escape")]
    app.step(0.2)
    assert not window.should_close


def test_the_window_is_hidden_while_a_call_is_connected(app: StartApp, window: ScriptedWindow, stand: Stand) -> None:
    stand.controller.wait_at_port()
    app.step(0.0)
    assert window.visible and window.drawn == 1
    stand.calls[0].messages = ["connected with Bea"]
    app.step(0.1)
    assert not window.visible and window.drawn == 1
    stand.calls[0].is_running = False
    app.step(0.2)
    assert window.visible and window.drawn == 2


def test_what_is_copied_is_in_the_clipboard(
    app: StartApp, window: ScriptedWindow, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(WaitingPanel, "draw", lambda *_: "acorn-tulip-river-42")
    stand.controller.wait_at_port()
    app.step(0.0)
    assert window.clipboard == "acorn-tulip-river-42"


def test_it_runs_until_the_window_is_closed(app: StartApp, window: ScriptedWindow) -> None:
    window.events = [KeyPressed("escape")]
    app.run()
    assert window.should_close and window.drawn == 1
