"""`conf doctor`: check what works on this machine and say what to do about the rest.

Strategy: each check runs in a process of its own, `conf doctor --check NAME`. A graphics driver or a camera that ends
or blocks the process costs its own check only, and a window opens in a process that has made no other OpenGL context,
which some drivers do not survive.
"""

from __future__ import annotations

import argparse
import json
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_json, add_listen, relay_address
from conf.commands.support.child_process import start_conf
from conf.commands.support.display import has_display
from conf.errors import ConfError
from conf.protocol.address import DEFAULT_PORT

if TYPE_CHECKING:
    import subprocess

HELP = "what works on this machine, what does not, what to do"
DEFAULT_LISTEN = ("127.0.0.1", DEFAULT_PORT)
TIMED_FRAMES = 20
SOUND_LIMIT_S = 3.0  # until a sound device must have called back

DRIVER = "install a driver with `sudo apt install libgl1 libegl1 libgl1-mesa-dri`, or try LIBGL_ALWAYS_SOFTWARE=1"


@dataclass(frozen=True)
class CheckResult:
    """One check. detail : what was found or what to do"""

    name: str
    works: bool
    detail: str


@dataclass(frozen=True)
class Check:
    """One check of this machine.

    name : what the user reads
    run : returns what was found. Raises ConfError
    limit_s : seconds until the check is ended
    remedy : what to do when the check's process has died or hangs
    """

    name: str
    run: Callable[[argparse.Namespace], str]
    limit_s: float
    remedy: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--camera", default="0", metavar="N", help="number or device of the camera (default 0)")
    add_listen(parser, default=DEFAULT_LISTEN)
    parser.add_argument(
        "--relay", type=relay_address, metavar="HOST[:PORT]", help="also check the way to this relay, and the NAT"
    )
    parser.add_argument("--relay-password", type=Path, metavar="FILE", help="for the relay: a line user:password")
    checks = [*CHECKS, *RELAY_CHECKS]
    parser.add_argument(
        "--check", choices=checks, metavar="CHECK", help=f"make only this check, in this process: {', '.join(checks)}"
    )
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    if options.check in RELAY_CHECKS and options.relay is None:
        raise ConfError(f"--check {options.check} needs the name of a relay: give it with --relay HOST")
    if options.check:
        findings = [run_check((CHECKS | RELAY_CHECKS)[options.check], options)]
    else:
        keys = [*CHECKS, *(RELAY_CHECKS if options.relay else ())]
        with terminal.status_line() as show:
            findings = [_run_in_child(key, options, show) for key in keys]
    lines = [f"{'works' if finding.works else 'FAILS'}  {finding.name}: {finding.detail}" for finding in findings]
    terminal.print_list("findings", findings, "\n".join(lines))


def run_check(check: Check, options: argparse.Namespace) -> CheckResult:
    """Make a check in this process."""
    try:
        return CheckResult(check.name, True, check.run(options))
    except ConfError as error:
        return CheckResult(check.name, False, str(error))


def _run_in_child(key: str, options: argparse.Namespace, show: Callable[[str], None]) -> CheckResult:
    from conf.protocol.address import format_address

    check = (CHECKS | RELAY_CHECKS)[key]
    show(f"checking: {check.name}")
    host, port = options.listen
    listen = format_address((host, port)) if host else str(port)
    arguments = ["doctor", "--check", key, f"--camera={options.camera}", "--listen", listen, "--json"]
    if options.relay:
        arguments += ["--relay", format_address(options.relay)]
    if options.relay_password:
        arguments.append(f"--relay-password={options.relay_password}")
    return collect(check, lambda: start_conf(arguments))


def collect(check: Check, start: Callable[[], subprocess.Popen[str]], /) -> CheckResult:
    """Return what the process of a check has found, or how it ended without an answer and what to do about that."""
    import subprocess

    with start() as process:
        try:
            output, errors = process.communicate(timeout=check.limit_s)
        except subprocess.TimeoutExpired:
            return CheckResult(check.name, False, f"no answer within {check.limit_s:.0f} s: {check.remedy}")
        finally:
            process.kill()
    try:
        (finding,) = json.loads(output)["findings"]
        return CheckResult(**finding)
    except (ValueError, TypeError, KeyError):
        reason = next((line.strip() for line in errors.splitlines() if line.strip()), "without a message")
        return CheckResult(check.name, False, f"{_ending(process.returncode)} ({reason}): {check.remedy}")


def _ending(status: int) -> str:
    """Return how a process ended, by its exit status, which is minus the signal's number if a signal ended it."""
    if status >= 0:
        return f"the check ended with status {status}"
    names: Sequence[str] = [member.name for member in signal.Signals if member.value == -status]
    return f"the check was ended by {names[0] if names else f'signal {-status}'}"


def _check_files(_: argparse.Namespace) -> str:
    from conf.sender.tracking.model_files import fetch_models

    return str(fetch_models())


def _check_tracker(_: argparse.Namespace) -> str:
    """Return the backend and its time; the time is that of the landmarks, most of a frame's."""
    import numpy as np

    from conf.sender.tracking.inference import describe_backend
    from conf.sender.tracking.landmarks import Crop, LandmarkNetwork
    from conf.sender.tracking.model_files import model_folder

    network = LandmarkNetwork(model_folder())
    image, crop = np.zeros((240, 320, 3), np.uint8), Crop(np.array([160.0, 120.0]), 200.0, 0.0)
    times = []
    for _frame in range(TIMED_FRAMES):
        start = time.perf_counter()
        network.predict(image, crop)
        times.append(time.perf_counter() - start)
    return f"{describe_backend()}, {float(np.median(times)) * 1000:.1f} ms a frame"


def _check_camera(options: argparse.Namespace) -> str:
    from conf.sender.capture.camera import open_camera

    with open_camera(options.camera) as camera:
        height, width = camera.read().pixels.shape[:2]
    return f"{width}x{height}"


def _check_sound(_: argparse.Namespace) -> str:
    """Return the names of the default microphone and speaker after both have run for a moment."""
    from conf.audio.devices import open_microphone, open_speaker
    from conf.errors import AudioError

    found, faults = [], []
    for opener in (open_microphone, open_speaker):
        try:
            with opener() as device:
                device.wait_for_first_callback(SOUND_LIMIT_S)
                found.append(device.name)
        except AudioError as error:
            faults.append(str(error))
    if faults:
        raise ConfError(" ".join([*(f"{name} works," for name in found), *faults]))
    return " and ".join(found)


def _check_voice(_: argparse.Namespace) -> str:
    from conf.audio.codecs.registry import VOICE_CODECS, find_codec_fault
    from conf.audio.processing import VoiceProcessor

    faults = [*map(find_codec_fault, VOICE_CODECS), VoiceProcessor().fault]
    if any(faults):
        raise ConfError(" ".join(fault for fault in faults if fault))
    return ", ".join([*VOICE_CODECS, "noise suppression"])


def _check_offscreen(_: argparse.Namespace) -> str:
    from conf.render.window.offscreen import OffscreenWindow

    with OffscreenWindow(64, 64) as window:
        return str(window.ctx.info["GL_RENDERER"])


def _check_window(_: argparse.Namespace) -> str:
    from conf.render.window.glfw_window import GlfwWindow

    if not has_display():
        raise ConfError("there is no display here: `conf receive --headless OUT.mp4` draws into a file instead")
    with GlfwWindow(64, 64, "conf doctor") as window:
        window.begin()
        window.end()
        return str(window.ctx.info["GL_RENDERER"])


def _check_port(options: argparse.Namespace) -> str:
    from conf.protocol.address import format_address
    from conf.transport.udp import UdpSocket

    with UdpSocket.bind(*options.listen) as socket:
        return f"{format_address(socket.address)} is free"


def _check_nat(options: argparse.Namespace) -> str:
    from conf.commands.support.relay_checks import check_nat

    return check_nat(options.relay)


def _check_link(kind: str, options: argparse.Namespace) -> str:
    from conf.commands.support.relay_checks import check_link

    return check_link(options.relay, options.relay_password, kind)


CHECKS = {
    # pip tries again for a while before it says that there is no network
    "files": Check("tracker's files", _check_files, 180.0, "check the network, then type `conf models fetch`"),
    "tracker": Check(
        "tracker", _check_tracker, 30.0, "type `pip uninstall ai-edge-litert`: the tracker then runs on OpenCV"
    ),
    "camera": Check(
        "camera", _check_camera, 20.0, "plug the camera in again, close what uses it, or name another with --camera N"
    ),
    "sound": Check("sound devices", _check_sound, 20.0, "restart the sound system, or unplug and plug in the headset"),
    "voice": Check("voice codecs", _check_voice, 20.0, "type `pip install --force-reinstall av pycodec2`"),
    "offscreen": Check("drawing without a display", _check_offscreen, 20.0, DRIVER),
    "window": Check(
        "window", _check_window, 20.0, f"{DRIVER}, or draw without a window: `conf receive --headless OUT.mp4`"
    ),
    "port": Check("port", _check_port, 20.0, "name another with --listen HOST:PORT"),
}
RELAY_HANGS = "check the relay's name, and this machine's network"
RELAY_CHECKS = {
    "relay-udp": Check("relay over UDP", partial(_check_link, "udp"), 20.0, RELAY_HANGS),
    "relay-tcp": Check("relay over TCP", partial(_check_link, "tcp"), 20.0, RELAY_HANGS),
    "nat": Check("NAT", _check_nat, 20.0, RELAY_HANGS),
}
