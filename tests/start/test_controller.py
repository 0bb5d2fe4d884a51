"""What the controls do: settings are kept, devices follow them, calls begin and end."""

from pathlib import Path
from typing import Any

import pytest

from conf.protocol.session.pairing_code import generate_code
from conf.settings import Settings, load_settings
from conf.start.controller import STILL_BUSY
from conf.start.recent_calls import load_recent_calls
from conf.start.state import CallTarget, StartState
from tests.start.conftest import DEVICES, USED_PORT, Stand

CODE = "acorn-tulip-river-42"
RELAY_CODE = "4711-acorn-tulip-river"
Opened = dict[str, list[str | None]]


def typed(stand: Stand, address: str = "10.0.0.7", code: str = CODE) -> None:
    state = stand.controller.state
    stand.controller.state = state.with_field("address", address).with_field("code", code)


def test_devices_and_addresses_are_looked_for_when_the_window_opens(stand: Stand, devices: Opened) -> None:
    assert stand.controller.devices == DEVICES
    assert stand.controller.addresses == ("192.0.2.2", "2001:db8::2")
    assert devices == {"CameraPreview": ["0"], "MicrophoneMeter": [None], "SpeakerTest": []}


def test_a_setting_is_kept_and_its_device_opened_anew(stand: Stand, devices: Opened) -> None:
    before: Any = stand.controller.camera
    for name, value in (("camera", "2"), ("microphone", "Headset"), ("speaker", "HDMI"), ("kbps", 9.6)):
        stand.controller.set_setting(name, value)
        stand.controller.set_setting(name, value)
    assert before.is_closing
    assert devices == {"CameraPreview": ["0", "2"], "MicrophoneMeter": [None, "Headset"], "SpeakerTest": []}
    stand.controller.test_speaker()
    assert devices["SpeakerTest"] == ["HDMI"]
    kept = Settings(camera="2", microphone="Headset", speaker="HDMI", kbps=9.6)
    assert load_settings(stand.files.settings) == kept == stand.controller.settings


def test_a_broken_settings_file_is_named_and_kept(stand: Stand) -> None:
    stand.files.settings.write_text("name = Anna")
    controller = stand.open()
    assert controller.state.notice.startswith(f"the settings are ignored: {stand.files.settings}, line 1: expected")
    controller.set_setting("portrait", True)
    kept = stand.files.settings.with_name("settings.broken.toml")
    assert controller.state.notice == f"the former settings file could not be read; it is kept as {kept}"
    assert kept.read_text() == "name = Anna" and load_settings(stand.files.settings) == Settings(portrait=True)
    controller.close()


def test_settings_that_cannot_be_kept_hold_until_the_window_is_closed(stand: Stand, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    stand.controller._files = type(stand.files)(tmp_path / "file" / "s.toml", tmp_path / "file" / "r.json")
    stand.controller.set_setting("kbps", 6.0)
    assert "cannot be written" in stand.controller.state.notice and stand.controller.settings.kbps == 6.0
    stand.controller.clear_recent()
    assert "r.json cannot be written" in stand.controller.state.notice


def test_a_name_is_kept_if_it_is_one(stand: Stand) -> None:
    stand.controller.state = StartState(name=" Anna ")
    stand.controller.enter_name()
    stand.controller.state = StartState(name="a" * 41)
    stand.controller.enter_name()
    assert load_settings(stand.files.settings).name == "Anna" and stand.controller.state.name_error
    assert stand.open().state.name == "Anna"
    stand.controller.state = StartState(name="")
    stand.controller.enter_name()
    assert load_settings(stand.files.settings).name is None


def test_a_call_is_made_with_all_devices_released(stand: Stand, devices: Opened) -> None:
    camera: Any = stand.controller.camera
    microphone: Any = stand.controller.microphone
    typed(stand)
    stand.controller.set_setting("kbps", 9.6)
    stand.controller.call()
    (call,) = stand.calls
    assert (call.target, call.settings.kbps) == (CallTarget("10.0.0.7", 5005, CODE), 9.6)
    assert camera.is_released and microphone.is_released and stand.controller.camera is None
    call.messages = ["nobody has answered for 5 s", "connected with Bea"]
    stand.controller.update()
    assert stand.controller.is_connected and stand.controller.messages[-1] == "connected with Bea"
    call.is_running = False
    stand.controller.update()
    assert (stand.controller.state.page, stand.controller.is_connected) == ("home", False)
    assert devices["CameraPreview"] == ["0", "0"] and devices["MicrophoneMeter"] == [None, None]
    (recent,) = load_recent_calls(stand.files.recent_calls)
    assert (recent.address, recent.name) == ("10.0.0.7", "Bea")
    assert CODE not in stand.files.recent_calls.read_text() + stand.files.settings.read_text()


def test_a_field_with_an_error_starts_no_call(stand: Stand) -> None:
    stand.controller.call()
    for port in ("x", str(USED_PORT)):
        stand.controller.state = stand.controller.state.with_field("port", port)
        stand.controller.wait_at_port()
        assert stand.controller.state.port_error
    assert not stand.calls and stand.controller.state.page == "home" and stand.controller.camera is not None


def test_the_reason_of_a_failed_call_is_shown(stand: Stand) -> None:
    typed(stand)
    stand.controller.call()
    stand.calls[0].reason, stand.calls[0].is_running = "the code is wrong", False
    stand.controller.update()
    assert stand.controller.state.notice == "the code is wrong" and not stand.controller.recent
    assert stand.controller.state.address == "10.0.0.7"


def test_waiting_shows_a_new_code_until_it_is_ended(stand: Stand) -> None:
    stand.controller.wait_at_port()
    (call,) = stand.calls
    assert call.target == CallTarget(None, 5005, generate_code(lambda count: bytes(count)))
    assert stand.controller.state.page == "waiting" and not stand.controller.is_connected
    stand.controller.hang_up()
    stand.controller.update()
    assert call.hung_up == 1 and stand.controller.state.page == "waiting"
    call.is_running = False
    stand.controller.update()
    stand.controller.hang_up()
    assert call.hung_up == 1 and stand.controller.state.page == "home"


@pytest.mark.parametrize(
    ("host", "who", "address", "name"),
    [
        ("", "Bea", "", "Bea"),
        ("", "10.0.0.9", "10.0.0.9", ""),
        ("h:6001", "10.0.0.9", "h:6001", ""),
        ("", "fe80::1%eth0", "fe80::1%eth0", ""),
    ],
)
def test_a_recent_call_has_a_name_or_an_address(stand: Stand, host: str, who: str, address: str, name: str) -> None:
    if host:
        typed(stand, host)
        stand.controller.call()
    else:
        stand.controller.wait_at_port()
    stand.calls[0].messages = [f"connected with {who}"]
    stand.controller.update()
    (recent,) = stand.controller.recent
    assert (recent.address, recent.name) == (address, name)
    stand.controller.choose_recent(recent)
    assert stand.controller.state.address == (address or host)
    stand.controller.clear_recent()
    assert load_recent_calls(stand.files.recent_calls) == () == stand.controller.recent


def test_the_window_comes_back_when_the_other_one_has_left(stand: Stand) -> None:
    stand.controller.wait_at_port()
    (call,) = stand.calls
    call.messages = ["a stranger has hung up", "connected with Bea"]
    stand.controller.update()
    assert call.hung_up == 0
    call.messages = ["Bea has hung up"]
    stand.controller.update()
    assert call.hung_up == 1 and stand.controller.is_connected
    call.is_running = False
    stand.controller.update()
    assert stand.controller.state.notice == "Bea has hung up" and not stand.controller.is_connected


def test_a_name_that_is_known_later_is_added(stand: Stand) -> None:
    stand.controller.wait_at_port()
    stand.calls[0].messages, stand.calls[0].name = ["connected with 10.0.0.9"], "Bea"
    stand.controller.update()
    stand.calls[0].is_running = False
    stand.controller.update()
    (recent,) = load_recent_calls(stand.files.recent_calls)
    assert (recent.address, recent.name) == ("10.0.0.9", "Bea")


def test_a_device_that_is_not_released_is_mentioned(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stand.controller.camera, "close", lambda: False)
    stand.controller.wait_at_port()
    assert stand.controller.messages == [STILL_BUSY]


def test_one_animator_is_opened_and_its_failure_shown(stand: Stand) -> None:
    stand.controller.animate()
    stand.controller.animate()
    (animator,) = stand.animators
    stand.controller.update()
    animator.reason, animator.is_running = "the display has no OpenGL 3.3", False
    stand.controller.update()
    assert stand.controller.state.notice == "the display has no OpenGL 3.3"
    stand.controller.animate()
    assert len(stand.animators) == 2


def test_closing_ends_the_call(stand: Stand) -> None:
    stand.controller.wait_at_port()
    stand.controller.close()
    assert stand.calls[0].closed


def test_waiting_over_a_relay_shows_the_code_that_the_call_has_got(stand: Stand) -> None:
    stand.controller.state = stand.controller.state.with_field("relay", "relay.example")
    stand.controller.wait_for_call()
    (call,) = stand.calls
    assert call.target == CallTarget(None, 0, "", relay="relay.example")
    call.messages = [f"code {RELAY_CODE}"]
    stand.controller.update()
    assert stand.controller.state.target and stand.controller.state.target.code == RELAY_CODE
    assert stand.controller.messages == []


@pytest.mark.parametrize(("name", "kept"), [("Bea", ["Bea"]), ("", [])])
def test_a_recent_call_over_a_relay_is_a_name_and_never_a_code(stand: Stand, name: str, kept: list[str]) -> None:
    stand.controller.state = stand.controller.state.with_field("code", RELAY_CODE)
    stand.controller.call()
    (call,) = stand.calls
    call.messages, call.name = ["connected with "], name
    stand.controller.update()
    assert stand.controller.is_connected and not stand.controller.recent
    call.is_running = False
    stand.controller.update()
    recent = stand.controller.recent
    assert [item.name for item in recent] == kept and {item.address for item in recent} <= {""}
    files = [path.read_text() for path in (stand.files.recent_calls, stand.files.settings) if path.exists()]
    assert not any("4711" in text or "tulip" in text for text in files)


def test_the_relay_is_kept_if_it_is_one(stand: Stand) -> None:
    for typed_relay, kept in (("relay.example:99", "relay.example:99"), ("a b:c", "relay.example:99"), ("", None)):
        stand.controller.state = stand.controller.state.with_field("relay", typed_relay)
        stand.controller.enter_relay()
        assert load_settings(stand.files.settings).relay == kept
    assert stand.open(relay="other.example").state.relay == "other.example"
    assert load_settings(stand.files.settings).relay is None
