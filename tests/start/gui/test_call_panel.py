"""The left column, clicked and typed into."""

from datetime import UTC, datetime

import pytest

from conf.render.window.input_events import KeyStateChanged, TextInput
from conf.start.gui.call_panel import WAIT_AT_PORT, draw_call_panel
from conf.start.recent_calls import RecentCall
from conf.start.state import NO_ADDRESS, NO_CODE, CallTarget
from tests.start.conftest import Stand
from tests.support.imgui_stage import Stage

NOW = datetime(2026, 3, 2, 12, 0, tzinfo=UTC)


def test_an_address_and_a_code_are_typed_and_enter_calls(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw() -> None:
        draw_call_panel(stand.controller, NOW)

    stage.frame(draw)
    for label, text in ("##address", "10.0.0.7"), ("##code", "acorn tulip river 42"):
        stage.click(*stage.find(label, draw, monkeypatch), draw)
        stage.feed(TextInput(text), draw)
        stage.frame(draw)
    stage.feed(KeyStateChanged("enter", True), draw)
    stage.frame(draw)
    (call,) = stand.calls
    assert call.target is not None and (call.target.host, call.target.code) == ("10.0.0.7", "acorn-tulip-river-42")


def test_the_buttons_call_and_wait(stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    def draw() -> None:
        draw_call_panel(stand.controller, NOW)

    stage.frame(draw)
    stage.click(*stage.find("Call", draw, monkeypatch), draw)
    assert stand.controller.state.address_error and stand.controller.state.code_error
    stage.click(*stage.find("Wait for a call", draw, monkeypatch), draw)
    assert stand.controller.state.page == "waiting" and len(stand.calls) == 1


@pytest.mark.slow
def test_a_recent_call_fills_in_its_address(stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = (RecentCall("10.0.0.7", NOW, "Anna"), RecentCall("", NOW, "Bea"), RecentCall("h:6001", NOW))
    stand.controller.recent = calls

    def draw() -> None:
        draw_call_panel(stand.controller, NOW)

    stage.frame(draw)
    for number, address in ((1, ""), (0, "10.0.0.7"), (2, "h:6001"), (1, "h:6001")):
        stage.click(*stage.find(f"##call {number}", draw, monkeypatch), draw)
        assert stand.controller.state.address == address
    stage.click(*stage.find("Clear", draw, monkeypatch), draw)
    assert stand.controller.recent == ()


def test_a_code_with_its_number_in_front_needs_no_address(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw() -> None:
        draw_call_panel(stand.controller, NOW)

    stand.controller.state = stand.controller.state.with_field("address", "10.0.0.7")
    stage.frame(draw)
    for label, text in ("##relay", "relay.example"), ("##code", "4711 acorn tulip river"):
        stage.click(*stage.find(label, draw, monkeypatch), draw)
        stage.feed(TextInput(text), draw)
        stage.frame(draw)
    assert stand.controller.settings.relay == "relay.example"
    stage.feed(KeyStateChanged("enter", True), draw)
    stage.frame(draw)
    (call,) = stand.calls
    assert call.target == CallTarget(None, 0, "4711-acorn-tulip-river", relay="relay.example", nameplate="4711")
    assert stand.controller.state.address == "10.0.0.7"


def test_no_address_is_missed_once_the_code_needs_none(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors: list[str] = []
    monkeypatch.setattr("conf.start.gui.widgets.draw_error", errors.append)

    def draw() -> None:
        errors.clear()
        draw_call_panel(stand.controller, NOW)

    stand.controller.call()
    stage.frame(draw)
    assert errors == [NO_CODE, NO_ADDRESS]
    stand.controller.state = stand.controller.state.with_field("code", "4711-acorn-tulip-river")
    stage.frame(draw)
    assert errors == []


def test_one_waits_at_a_port_with_a_button_or_enter(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw() -> None:
        draw_call_panel(stand.controller, NOW)

    stage.frame(draw)
    stage.click(*stage.find(WAIT_AT_PORT, draw, monkeypatch), draw)
    assert stand.calls[0].target and stand.calls[0].target.port == 5005
    stand.controller.state = stand.controller.state.end_call("").with_field("port", "x")
    stage.frame(draw)
    stage.click(*stage.find(WAIT_AT_PORT, draw, monkeypatch), draw)
    assert len(stand.calls) == 1 and stand.controller.state.port_error
    stage.frame(draw)
