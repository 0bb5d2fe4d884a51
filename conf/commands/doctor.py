"""`conf doctor`: check what works on this machine and say what to do about the rest."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from conf.commands import Terminal
from conf.commands.arguments import add_json, add_listen
from conf.commands.receive import has_display
from conf.errors import ConfError

HELP = "what works on this machine, what does not, what to do"


@dataclass(frozen=True)
class CheckResult:
    """One check. detail : what was found or what to do"""

    name: str
    works: bool
    detail: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--camera", default="0", metavar="N")
    add_listen(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    host, port = options.listen
    findings = run_checks(camera=options.camera, host=host, port=port)
    lines = [f"{'works' if finding.works else 'FAILS'}  {finding.name}: {finding.detail}" for finding in findings]
    terminal.print_list("findings", findings, "\n".join(lines))


def run_checks(*, camera: str, host: str, port: int) -> list[CheckResult]:
    """Check everything that a call needs; a failure does not stop the other checks."""
    from conf.sender.tracking.model_files import fetch_models

    checks: dict[str, Callable[[], str]] = {
        "tracker's files": lambda: str(fetch_models()),
        "camera": lambda: _check_camera(camera),
        "drawing without a display": _check_offscreen,
        "window": _check_window,
        "port": lambda: _check_port(host, port),
    }
    return [_run_check(name, check) for name, check in checks.items()]


def _run_check(name: str, check: Callable[[], str]) -> CheckResult:
    try:
        return CheckResult(name, True, check())
    except ConfError as error:
        return CheckResult(name, False, str(error))


def _check_camera(name: str) -> str:
    from conf.sender.capture.camera import open_camera

    with open_camera(name) as camera:
        frame = camera.read()
    if frame is None:
        raise ConfError("the camera opens but gives no image: close the program that uses it, or try another number")
    height, width = frame.pixels.shape[:2]
    return f"{width}x{height}"


def _check_offscreen() -> str:
    from conf.render.window.offscreen import OffscreenWindow

    with OffscreenWindow(64, 64) as window:
        return str(window.ctx.info["GL_RENDERER"])


def _check_window() -> str:
    from conf.render.window.glfw_window import GlfwWindow

    if not has_display():
        raise ConfError("there is no display here: `conf receive --headless OUT.avi` draws into a file instead")
    with GlfwWindow(64, 64, "conf doctor") as window:
        return str(window.ctx.info["GL_RENDERER"])


def _check_port(host: str, port: int) -> str:
    from conf.protocol.address import format_address
    from conf.transport.udp import UdpSocket

    with UdpSocket.bind(host, port) as socket:
        return f"{format_address(socket.address)} is free"
