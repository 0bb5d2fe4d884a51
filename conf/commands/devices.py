"""`conf devices`: the cameras, microphones and speakers of this machine."""

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from conf.commands import Terminal
from conf.commands.support.arguments import add_json

HELP = "the cameras, microphones and speakers of this machine"

# kind -> option that takes a device's number, what to do without one
KINDS = {
    "camera": ("--camera", "plug one in, or send a clip with --file"),
    "microphone": ("--microphone", "plug one in, or go on without sound"),
    "speaker": ("--speaker", "plug one in, or go on without sound"),
}


@dataclass(frozen=True)
class Device:
    """A camera, microphone or speaker. number : what the option of its kind takes"""

    kind: str
    number: int
    name: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    devices = find_devices()
    terminal.print_list("devices", devices, describe_devices(devices))


def find_devices() -> list[Device]:
    """Return all devices, cameras first."""
    from conf.audio.devices import list_microphones, list_speakers
    from conf.sender.capture.camera_list import list_cameras

    return [
        *(Device("camera", device.number, device.name) for device in list_cameras()),
        *(Device("microphone", device.number, device.name) for device in list_microphones()),
        *(Device("speaker", device.number, device.name) for device in list_speakers()),
    ]


def describe_devices(devices: Sequence[Device], /) -> str:
    """Return a list for the user, with what to do where a kind has none."""
    return "\n".join(line for kind in KINDS for line in _describe_kind(kind, devices))


def _describe_kind(kind: str, devices: Sequence[Device]) -> Iterable[str]:
    option, remedy = KINDS[kind]
    of_kind = [device for device in devices if device.kind == kind]
    if not of_kind:
        yield f"no {kind}: {remedy}"
        return
    yield f"{kind}s, for {option}:"
    for device in of_kind:
        yield f"  {device.number}  {device.name}"
