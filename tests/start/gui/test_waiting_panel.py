"""The page while a call is prepared."""

import pytest

from conf.start.gui.waiting_panel import COPIED, COPIED_S, WaitingPanel
from tests.start.conftest import Stand
from tests.support.imgui_stage import Stage

RELAY_CODE = "4711-acorn-tulip-river"


def test_the_code_and_the_addresses_can_be_copied(stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    panel, copied = WaitingPanel(), list[str]()
    now = [1.0]

    def draw() -> None:
        text = panel.draw(stand.controller, stage.overlay, now[0])
        if text is not None:
            copied.append(text)

    stand.controller.wait_at_port()
    target = stand.controller.state.target
    assert target is not None
    stage.frame(draw)
    stage.click(*stage.find(f"Copy the code###{target.code}", draw, monkeypatch), draw)
    assert copied == [target.code] and f"{COPIED}###{target.code}" in stage.widgets(draw, monkeypatch)
    stage.click(*stage.find("Copy###2001:db8::2", draw, monkeypatch), draw)
    assert copied[1:] == ["2001:db8::2"] and f"{COPIED}###2001:db8::2" in stage.widgets(draw, monkeypatch)
    now[0] += COPIED_S
    assert f"Copy the code###{target.code}" in stage.widgets(draw, monkeypatch)
    stage.click(*stage.find("Stop waiting", draw, monkeypatch), draw)
    assert stand.calls[0].hung_up == 1


@pytest.mark.parametrize("addresses", [None, ()])
def test_the_page_is_drawn_without_addresses(stage: Stage, stand: Stand, addresses: tuple[str, ...] | None) -> None:
    stand.controller.wait_at_port()
    stand.controller.addresses = addresses
    stage.frame(lambda: WaitingPanel().draw(stand.controller, stage.overlay, 0.0))


def test_a_call_is_cancelled_before_and_hung_up_after_it_is_connected(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = stand.controller.state.with_field("address", "h").with_field("code", "acorn-tulip-river-42")
    stand.controller.state = state
    stand.controller.call()
    panel = WaitingPanel()

    def draw() -> None:
        panel.draw(stand.controller, stage.overlay, 0.0)

    stage.frame(draw)
    stage.click(*stage.find("Cancel", draw, monkeypatch), draw)
    stand.controller.state = stand.controller.state.connect()
    stage.frame(draw)
    stage.click(*stage.find("Hang up", draw, monkeypatch), draw)
    assert stand.calls[0].hung_up == 2


@pytest.mark.parametrize("relay", ["", "relay.example"])
def test_over_a_relay_the_code_appears_when_it_is_known(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch, relay: str
) -> None:
    copied = list[str]()
    panel = WaitingPanel()

    def draw() -> None:
        if text := panel.draw(stand.controller, stage.overlay, 1.0):
            copied.append(text)

    stand.controller.state = stand.controller.state.with_field("relay", relay)
    stand.controller.wait_for_call()
    stage.frame(draw)
    assert not any("Copy" in widget for widget in stage.widgets(draw, monkeypatch))
    stand.controller.state = stand.controller.state.show_code(RELAY_CODE)
    assert [w for w in stage.widgets(draw, monkeypatch) if "Copy" in w] == [f"Copy the code###{RELAY_CODE}"]
    stage.click(*stage.find(f"Copy the code###{RELAY_CODE}", draw, monkeypatch), draw)
    assert copied == [RELAY_CODE]


def test_a_message_that_repeats_the_code_is_left_out(
    stage: Stage, stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    hints: list[str] = []
    monkeypatch.setattr("conf.start.gui.waiting_panel.hint", hints.append)
    stand.controller.wait_at_port()
    target = stand.controller.state.target
    assert target is not None
    for message in (f"listening on 0.0.0.0:5005, code {target.code}", "a wrong code from 192.0.2.7: 3 more tries"):
        stand.controller.messages = [message]
        stage.frame(lambda: WaitingPanel().draw(stand.controller, stage.overlay, 0.0))
    assert [text for text in hints if "code" in text] == ["a wrong code from 192.0.2.7: 3 more tries"]
