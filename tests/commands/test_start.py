"""What the start window asks of `conf call`, and what it understands of its messages."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from conf.call.events import describe_event
from conf.cli import INTERRUPTED, build_parser
from conf.commands import start
from conf.commands.start import call_arguments, code_in, connected_with, says_end, start_animator, start_call
from conf.commands.support.relay_route import RelayRoute, describe_waiting
from conf.protocol.address import RelayAddress
from conf.protocol.session.events import Connected, LossReason, SessionEnded
from conf.settings import PATH_VARIABLE, Settings
from conf.start.state import CallTarget

REPOSITORY = Path(__file__).resolve().parents[2]
LIMIT_S = 60.0
CODE = "acorn-tulip-river-42"
RELAY_CODE = "4711-acorn-tulip-river"
SETTINGS = Settings("-Anna", "2", "Headset", "HDMI", True, 9.6, "codec2", Path("/tmp/a.obj"), "mei")


def parse(target: CallTarget, settings: Settings) -> dict[str, Any]:
    return vars(build_parser().parse_args(call_arguments(target, settings)))


def test_the_settings_of_the_window_are_options_of_the_call() -> None:
    options = parse(CallTarget("::1", 6001, CODE), SETTINGS)
    expected = {
        "remote": ("::1", 6001), "listen": None, "name": "-Anna", "camera": "2", "microphone": "Headset",
        "speaker": "HDMI", "portrait": True, "kbps": 9.6, "voice": "codec2", "face": Path("/tmp/a.obj"),
        "head": "mei", "json": True,
    }  # fmt: skip
    assert options.items() >= expected.items()


def test_without_settings_a_call_has_the_defaults_of_its_options() -> None:
    arguments = call_arguments(CallTarget(None, 5005, CODE), Settings())
    assert arguments == ["call", "--listen=5005", "--name=", "--show-when-connected", "--json"]
    assert parse(CallTarget(None, 5005, CODE), Settings())["listen"] == ("", 5005)


def test_the_code_is_not_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[tuple[list[str], Any]] = []
    monkeypatch.setattr(
        start, "start_conf", lambda arguments, environment=None: started.append((arguments, environment))
    )
    monkeypatch.setattr("conf.start.call_process.CallProcess", lambda process: process)
    start_call(CallTarget(None, 5005, CODE), SETTINGS)
    start_animator()
    (call, environment), animator = started
    assert not any(CODE in argument for argument in call)
    assert environment["CONF_CODE"] == CODE and PATH_VARIABLE in environment
    assert animator == (["animate"], None)


@pytest.mark.parametrize(
    ("message", "name"),
    [("connected with Anna Lee", "Anna Lee"), ("connected with 10.0.0.7", "10.0.0.7"), ("Anna has hung up", None),
     ("nobody is connected with", None)],
)  # fmt: skip
def test_who_is_there_is_read_from_a_message(message: str, name: str | None) -> None:
    assert connected_with(message) == name


@pytest.mark.parametrize(
    ("reason", "is_end"), [(LossReason.HUNG_UP, True), (LossReason.IDLE, True), (LossReason.REPLACED, False)]
)
def test_the_end_of_a_call_is_read_from_its_message(reason: LossReason, is_end: bool) -> None:
    assert says_end(describe_event(SessionEnded(1, reason), name="Bea", is_calling=False)) is is_end


def test_a_connection_is_read_from_the_message_of_the_call() -> None:
    event = Connected(1, ("10.0.0.7", 5005))
    assert connected_with(describe_event(event, name="", is_calling=True)) == "10.0.0.7"


@pytest.mark.slow
def test_conf_alone_opens_the_window_and_ends_in_order(display: str, tmp_path: Path) -> None:
    environment = os.environ | {
        "DISPLAY": display,
        "XDG_STATE_HOME": str(tmp_path),
        "PULSE_SERVER": str(tmp_path / "none"),
        PATH_VARIABLE: str(tmp_path / "settings.toml"),
    }
    command = [sys.executable, "-W", "error", "-m", "conf"]
    process = subprocess.Popen(command, env=environment, cwd=REPOSITORY, stderr=subprocess.PIPE, text=True)
    watchdog = threading.Timer(LIMIT_S, process.kill)
    watchdog.start()
    search = ["xdotool", "search", "--sync", "--onlyvisible", "--name", "^conf$"]
    subprocess.run(search, env=environment, check=True, capture_output=True, timeout=LIMIT_S)
    process.terminate()
    _, errors = process.communicate()
    watchdog.cancel()
    assert (process.returncode, errors) == (INTERRUPTED, "")
    assert not (tmp_path / "settings.toml").exists()


def test_a_call_over_a_relay_has_only_the_number_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONF_RELAY", "ignored.example")
    calling = CallTarget(None, 0, RELAY_CODE, relay="relay.example:99", nameplate="4711")
    options = parse(calling, Settings())
    assert (options["remote"], options["listen"], options["relay"]) == ("4711", None, ("relay.example", 99))
    waiting = parse(CallTarget(None, 0, "", relay="relay.example"), Settings())
    assert (waiting["remote"], waiting["listen"], waiting["relay"]) == (None, None, ("relay.example", 7447))
    assert not any("relay" in argument for argument in call_arguments(CallTarget(None, 0, "", relay=""), Settings()))
    environments: list[dict[str, str]] = []
    monkeypatch.setattr(start, "start_conf", lambda arguments, environment: environments.append(environment))
    monkeypatch.setattr("conf.start.call_process.CallProcess", lambda process: process)
    start_call(calling, SETTINGS)
    assert (environments[0]["CONF_CODE"], environments[0]["CONF_RELAY"]) == (RELAY_CODE, "")


def test_the_code_for_a_relay_is_read_from_the_message_of_the_call() -> None:
    class Waiting:
        nameplate = "4711"

    for route in (RelayRoute(("relay.example", 7447)), RelayRoute()):
        text = f"{describe_waiting(Waiting(), route)}, code {RELAY_CODE}"  # type: ignore[arg-type]
        assert code_in(text) == RELAY_CODE
    assert code_in(f"listening on 0.0.0.0:5005, code {CODE}") is None


def test_who_has_no_name_over_a_relay_is_nobody_known() -> None:
    event = Connected(1, RelayAddress("4711", ""))
    assert connected_with(describe_event(event, name="", is_calling=True, nameplate="4711")) == ""
