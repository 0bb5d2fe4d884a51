"""The devices that a list offers, and which setting each stands for."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from conf.audio.devices import SoundDevice, list_microphones, list_speakers
from conf.sender.capture.camera_list import CameraDevice, list_cameras


@dataclass(frozen=True)
class DeviceLists:
    """The devices of this machine."""

    cameras: tuple[CameraDevice, ...] = ()
    microphones: tuple[SoundDevice, ...] = ()
    speakers: tuple[SoundDevice, ...] = ()


@dataclass(frozen=True)
class Choice:
    """A row of a list. value : of the setting, None for the default"""

    label: str
    value: str | None


def find_devices() -> DeviceLists:
    """Return the devices of this machine, as `conf devices` lists them."""
    return DeviceLists(list_cameras(), list_microphones(), list_speakers())


def camera_choices(cameras: Sequence[CameraDevice], setting: str | None, /) -> list[Choice]:
    """Return the cameras by number; first the one without a setting, which is number 0."""
    choices = [Choice(f"{camera.number}: {camera.name}", str(camera.number)) for camera in cameras]
    return _with_setting([Choice("the first camera", None), *choices], setting)


def sound_choices(devices: Sequence[SoundDevice], setting: str | None, /) -> list[Choice]:
    """Return microphones or speakers by name, or by number where two have the same; first the system's default.

    Names stay what they are when devices are plugged in and out.
    """
    names = [device.name for device in devices]
    choices = [
        Choice(device.name, device.name) if names.count(device.name) == 1 else _numbered(device) for device in devices
    ]
    return _with_setting([Choice("the system's", None), *choices], setting)


def selected_index(choices: Sequence[Choice], setting: str | None, /) -> int:
    """Return the row of a setting."""
    return next(number for number, choice in enumerate(choices) if choice.value == setting)


def sound_setting(devices: Iterable[SoundDevice], setting: str | None, /) -> str | None:
    """Return the value that a row has for a setting, which may be a number or part of a name as options take them."""
    if setting is None:
        return None
    names = [device.name for device in devices]
    if setting.isdecimal():
        by_number = [device.name for device in devices if device.number == int(setting)]
        return by_number[0] if by_number and names.count(by_number[0]) == 1 else setting
    matches = [name for name in names if setting.lower() in name.lower()]
    return matches[0] if len(matches) == 1 and setting not in names else setting


def _numbered(device: SoundDevice) -> Choice:
    return Choice(f"{device.number}: {device.name}", str(device.number))


def _with_setting(choices: list[Choice], setting: str | None) -> list[Choice]:
    """Return the choices, with a row for a setting that none of them has: an address, or a device not plugged in."""
    if any(choice.value == setting for choice in choices):
        return choices
    return [*choices, Choice(f"{setting} (not found)" if "/" not in str(setting) else str(setting), setting)]
