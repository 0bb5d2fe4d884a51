"""A controller whose devices, calls and search are stand-ins, and the ImGui stage."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conf.audio.devices import SoundDevice
from conf.sender.capture.camera_list import CameraDevice
from conf.settings import Settings
from conf.start import controller as controller_module
from conf.start.controller import Files, Programs, StartController
from conf.start.devices.choices import DeviceLists
from conf.start.state import CallTarget
from tests.support.imgui_stage import stage

__all__ = ["stage"]

USED_PORT = 5999
DEVICES = DeviceLists(
    (CameraDevice(0, "Integrated"), CameraDevice(2, "USB")), (SoundDevice(0, "Headset"),), (SoundDevice(0, "HDMI"),)
)


class FakeDevice:
    """A camera, microphone or speaker that is open at once. opened : what was asked for, in order"""

    opened: list[str | None]

    def __init__(self, which: str | None) -> None:
        self.opened.append(which)
        self.which = which
        self.error = ""
        self.level = 0.5
        self.is_released = False
        self.is_closing = False

    def newest(self) -> tuple[int, Any]:
        return 1, np.full((3, 4, 4), 255, np.uint8)

    def begin_close(self) -> None:
        self.is_closing = True

    def close(self) -> bool:
        self.is_released = True
        return True


class FakeCall:
    """A call whose process a test drives."""

    def __init__(self, target: CallTarget | None, settings: Settings) -> None:
        self.target, self.settings = target, settings
        self.is_running = True
        self.messages: list[str] = []
        self.reason = ""
        self.name = ""
        self.hung_up = 0
        self.closed = False

    def read_messages(self) -> list[str]:
        messages, self.messages = self.messages, []
        return messages

    def figures(self) -> dict[str, Any]:
        return {"name": self.name}

    def end_text(self) -> str:
        return self.reason

    def hang_up(self) -> None:
        self.hung_up += 1

    def close(self) -> None:
        self.closed = True


class Stand:
    """The controller, its files, and the calls that it has started."""

    def __init__(self, folder: Path) -> None:
        self.files = Files(folder / "settings.toml", folder / "recent_calls.json")
        self.calls: list[FakeCall] = []
        self.animators: list[FakeCall] = []
        self.controller = self.open()

    def open(self, *, relay: str = "") -> StartController:
        """Return a new controller of the same files."""

        def start_call(target: CallTarget, settings: Settings) -> Any:
            self.calls.append(FakeCall(target, settings))
            return self.calls[-1]

        def start_animator() -> Any:
            self.animators.append(FakeCall(None, Settings()))
            return self.animators[-1]

        def connected_with(message: str) -> str | None:
            return message.removeprefix("connected with ") if message.startswith("connected with ") else None

        def says_end(message: str) -> bool:
            return message.endswith(" has hung up")

        def code_in(message: str) -> str | None:
            return message.removeprefix("code ") if message.startswith("code ") else None

        programs = Programs(start_call, start_animator, connected_with, says_end, code_in)
        controller = StartController(programs, self.files, random=lambda count: bytes(count), relay=relay)
        for search in controller._searches:
            search._thread.join()
        return controller


@pytest.fixture
def devices(monkeypatch: pytest.MonkeyPatch) -> dict[str, list[str | None]]:
    """What was opened of each kind; no device of this machine is."""
    opened: dict[str, list[str | None]] = {}
    for name in ("CameraPreview", "MicrophoneMeter", "SpeakerTest"):
        opened[name] = []
        monkeypatch.setattr(controller_module, name, type(name, (FakeDevice,), {"opened": opened[name]}))
    monkeypatch.setattr(controller_module, "find_devices", lambda: DEVICES)
    monkeypatch.setattr(controller_module, "find_local_addresses", lambda: ("192.0.2.2", "2001:db8::2"))
    monkeypatch.setattr(controller_module, "is_port_free", lambda port: port != USED_PORT)
    return opened


@pytest.fixture
def stand(tmp_path: Path, devices: dict[str, list[str | None]]) -> Iterator[Stand]:
    """A controller without settings and recent calls."""
    assert os.environ["CONF_SETTINGS"] == os.devnull
    stand = Stand(tmp_path)
    yield stand
    stand.controller.close()
