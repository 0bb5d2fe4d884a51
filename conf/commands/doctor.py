"""What works on this machine, what does not, and what to do about it."""

import os
from collections.abc import Callable
from dataclasses import dataclass

from conf.errors import ConfError
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.video import open_camera
from conf.sender.tracking.model_files import fetch_models
from conf.transport.udp import UdpSocket


@dataclass(frozen=True)
class CheckResult:
    """One thing that was tried. `detail` says what was found or what to do."""

    name: str
    works: bool
    detail: str


def run_checks(*, camera: str, host: str, port: int) -> list[CheckResult]:
    """Try everything that a call needs, and go on after each failure."""
    checks: dict[str, Callable[[], str]] = {
        "tracker's files": lambda: str(fetch_models()),
        "camera": lambda: _camera(camera),
        "drawing without a display": _offscreen,
        "window": _window,
        "port": lambda: _port(host, port),
    }
    return [_try(name, check) for name, check in checks.items()]


def _try(name: str, check: Callable[[], str]) -> CheckResult:
    try:
        return CheckResult(name, True, check())
    except ConfError as error:
        return CheckResult(name, False, str(error))


def _camera(name: str) -> str:
    with open_camera(name) as camera:
        frame = camera.read()
    if frame is None:
        raise ConfError("the camera opens but gives no picture: close the program that uses it, or try another number")
    height, width = frame.pixels.shape[:2]
    return f"{width}x{height}"


def _offscreen() -> str:
    with OffscreenWindow(64, 64) as window:
        return str(window.ctx.info["GL_RENDERER"])


def _window() -> str:
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or os.name != "posix"):
        raise ConfError("there is no display here: `conf receive --headless OUT.avi` draws into a file instead")
    with GlfwWindow(64, 64, "conf doctor") as window:
        return str(window.ctx.info["GL_RENDERER"])


def _port(host: str, port: int) -> str:
    with UdpSocket.bind(host, port) as link:
        return "{}:{} is free".format(*link.address)
