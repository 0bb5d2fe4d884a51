"""`conf devices`: what it prints with and without devices."""

import json

import pytest

from conf.audio import devices as sound
from conf.audio.devices import SoundDevice
from conf.cli import main
from conf.sender.capture import camera_list
from conf.sender.capture.camera_list import CameraDevice

NAMES = ("Headset", "Monitor of Built-in Audio")


def print_devices(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as exit_:
        main(["devices", *arguments])
    assert exit_.value.code == 0
    return capsys.readouterr().out


@pytest.fixture
def devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera_list, "list_cameras", lambda: (CameraDevice(2, "USB camera"),))
    monkeypatch.setattr(sound, "list_microphones", lambda: tuple(map(SoundDevice, range(2), NAMES)))
    monkeypatch.setattr(sound, "list_speakers", tuple)


def test_devices_are_listed_with_the_numbers_of_their_options(
    devices: None, capsys: pytest.CaptureFixture[str]
) -> None:
    assert print_devices(capsys).splitlines() == [
        "cameras, for --camera:",
        "  2  USB camera",
        "microphones, for --microphone:",
        "  0  Headset",
        "  1  Monitor of Built-in Audio",
        "no speaker: plug one in, or go on without sound",
    ]


def test_json_is_one_object(devices: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert json.loads(print_devices(capsys, "--json")) == {
        "devices": [
            {"kind": "camera", "number": 2, "name": "USB camera"},
            {"kind": "microphone", "number": 0, "name": "Headset"},
            {"kind": "microphone", "number": 1, "name": "Monitor of Built-in Audio"},
        ]
    }


def test_a_machine_without_devices_is_no_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(camera_list, "list_cameras", tuple)
    monkeypatch.setattr(sound, "list_microphones", tuple)
    monkeypatch.setattr(sound, "list_speakers", tuple)
    lines = print_devices(capsys).splitlines()
    assert lines[0] == "no camera: plug one in, or send a clip with --file" and len(lines) == 3
    assert json.loads(print_devices(capsys, "--json")) == {"devices": []}
