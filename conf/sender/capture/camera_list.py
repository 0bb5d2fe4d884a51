"""Which cameras this machine has, without opening them where the system tells.

OpenCV cannot list cameras. Linux describes them in files; elsewhere the numbers from 0 on are opened until one fails.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.errors import CameraError
from conf.sender.capture.camera import open_camera

_LINUX_FOLDER = Path("/sys/class/video4linux")
_MAX_CAMERAS = 10


@dataclass(frozen=True)
class CameraDevice:
    """A camera. number : what options take"""

    number: int
    name: str


def list_cameras() -> tuple[CameraDevice, ...]:
    """Return the cameras of this machine."""
    return read_linux_cameras(_LINUX_FOLDER) if sys.platform == "linux" else try_cameras(_describe)


def read_linux_cameras(folder: Path, /) -> tuple[CameraDevice, ...]:
    """Return the cameras that the kernel lists in a folder: videoN/name, videoN/index."""
    cameras = []
    for device in folder.glob("video*"):
        number = device.name.removeprefix("video")
        # A camera has further device files, for metadata; their index is not 0.
        if number.isdecimal() and _read(device / "index", "0") == "0":
            cameras.append(CameraDevice(int(number), _read(device / "name", device.name)))
    return tuple(sorted(cameras, key=lambda camera: camera.number))


def try_cameras(describe: Callable[[int], str], /) -> tuple[CameraDevice, ...]:
    """Return the cameras from 0 to the first that describe raises CameraError for."""
    cameras: list[CameraDevice] = []
    for number in range(_MAX_CAMERAS):
        try:
            cameras.append(CameraDevice(number, describe(number)))
        except CameraError:
            break
    return tuple(cameras)


def _describe(number: int) -> str:
    with open_camera(number) as camera:
        return f"{camera.size[0]}x{camera.size[1]}"


def _read(path: Path, default: str) -> str:
    try:
        return path.read_text(errors="replace").strip() or default
    except OSError:
        return default
