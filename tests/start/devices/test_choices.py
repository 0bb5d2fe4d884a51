"""The rows of device lists, and the settings behind them."""

import pytest

from conf.audio.devices import SoundDevice
from conf.sender.capture.camera_list import CameraDevice
from conf.start.devices import choices
from conf.start.devices.choices import (
    Choice,
    camera_choices,
    find_devices,
    selected_index,
    sound_choices,
    sound_setting,
)

CAMERAS = (CameraDevice(0, "Integrated"), CameraDevice(2, "USB"))
SOUND = tuple(SoundDevice(number, name) for number, name in enumerate(("HDMI", "HDMI", "HDMI 3", "Headset")))


def test_cameras_are_chosen_by_number() -> None:
    rows = camera_choices(CAMERAS, "2")
    assert rows == [Choice("the first camera", None), Choice("0: Integrated", "0"), Choice("2: USB", "2")]
    assert [selected_index(rows, setting) for setting in (None, "0", "2")] == [0, 1, 2]


def test_sound_devices_are_chosen_by_name_where_it_is_one() -> None:
    rows = sound_choices(SOUND, None)
    assert [row.value for row in rows] == [None, "0", "1", "HDMI 3", "Headset"]
    assert [row.label for row in rows] == ["the system's", "0: HDMI", "1: HDMI", "HDMI 3", "Headset"]


@pytest.mark.parametrize(
    ("setting", "label"),
    [("7", "7 (not found)"), ("rtsp://10.0.0.9/", "rtsp://10.0.0.9/"), ("/dev/video9", "/dev/video9")],
)
def test_a_setting_that_is_no_device_has_a_row(setting: str, label: str) -> None:
    rows = camera_choices(CAMERAS, setting)
    assert rows[selected_index(rows, setting)].label == label
    assert sound_choices((), "Headset")[-1] == Choice("Headset (not found)", "Headset")


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        (None, None), ("3", "Headset"), ("0", "0"), ("headset", "Headset"), ("hdmi", "hdmi"), ("HDMI", "HDMI"),
        ("HDMI 3", "HDMI 3"), ("9", "9"), ("Mixer", "Mixer"),
    ],
)  # fmt: skip
def test_a_setting_by_number_or_part_of_a_name_finds_its_row(setting: str | None, value: str | None) -> None:
    assert sound_setting(SOUND, setting) == value


def test_the_devices_are_those_of_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choices, "list_cameras", lambda: CAMERAS)
    monkeypatch.setattr(choices, "list_microphones", lambda: SOUND)
    monkeypatch.setattr(choices, "list_speakers", tuple)
    found = find_devices()
    assert (found.cameras, found.microphones, found.speakers) == (CAMERAS, SOUND, ())
