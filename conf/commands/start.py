"""The start window, which `conf` alone opens. It starts calls and the animator as processes of their own."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING

from conf.commands.support.child_process import start_conf
from conf.commands.support.option_defaults import RELAY_VARIABLE
from conf.settings import PATH_VARIABLE, settings_path

if TYPE_CHECKING:
    from conf.settings import Settings
    from conf.start.call_process import CallProcess
    from conf.start.state import CallTarget

SIZE = (1000, 700)
CONNECTED = re.compile(r"connected with (.+)")  # messages of `conf call`, as conf/call/events.py has them
WAITING = re.compile(r"waiting over .+, code (\S+)")
UNKNOWN = "the other end"  # who has given no name, over a relay
LEFT = re.compile(r".+ (has hung up|has not been heard for .+: the call is over)")


def open_start_window() -> None:
    """Open the window and return when it is closed. Raises GraphicsError."""
    from conf.render.window.glfw_window import GlfwWindow
    from conf.start.app import StartApp
    from conf.start.controller import Files, Programs, StartController
    from conf.start.gui.layout import MIN_SIZE
    from conf.start.recent_calls import recent_calls_path

    programs = Programs(start_call, start_animator, connected_with, says_end, code_in)
    files = Files(settings_path(), recent_calls_path())
    with GlfwWindow(*SIZE, "conf", min_size=MIN_SIZE) as window:
        relay = os.environ.get(RELAY_VARIABLE, "")
        controller = StartController(programs, files, random=os.urandom, relay=relay)
        app = StartApp(window, controller)
        try:
            app.run()
        finally:
            controller.close()
            app.close()


def start_call(target: CallTarget, settings: Settings, /) -> CallProcess:
    """Start `conf call` with the settings of the window."""
    from conf.start.call_process import CallProcess

    # Neither the code is on the command line, which every user of the machine can read, nor is a settings file read,
    # which may be another than what the window shows.
    environment = {"CONF_CODE": target.code, RELAY_VARIABLE: "", PATH_VARIABLE: os.devnull}
    return CallProcess(start_conf(call_arguments(target, settings), environment=environment))


def start_animator() -> CallProcess:
    """Start `conf animate`."""
    from conf.start.call_process import CallProcess

    return CallProcess(start_conf(["animate"]))


def call_arguments(target: CallTarget, settings: Settings, /) -> list[str]:
    """Return the arguments of `conf` for a call, but for the code."""
    where = [f"--listen={target.port}"] if target.is_waiting else [target.address]
    if target.relay is not None:
        where = [target.nameplate] if target.nameplate else []
    options = {
        "name": settings.name or "",
        "camera": settings.camera,
        "microphone": settings.microphone,
        "speaker": settings.speaker,
        "kbps": None if settings.kbps is None else f"{settings.kbps:.10g}",
        "voice": settings.voice,
        "face": settings.face,
        "head": settings.head,
        "relay": target.relay or None,
    }
    given = [f"--{name}={value}" for name, value in options.items() if value is not None]
    return ["call", *where, *given, *(["--portrait"] if settings.portrait else []), "--show-when-connected", "--json"]


def connected_with(message: str, /) -> str | None:
    """Return the name or address of who is there now, "" if unknown, None for a message about something else."""
    match = CONNECTED.fullmatch(message)
    return match[1].removeprefix(UNKNOWN) if match else None


def code_in(message: str, /) -> str | None:
    """Return the code by which this end is called over a relay, None for a message about something else."""
    match = WAITING.fullmatch(message)
    return match[1] if match else None


def says_end(message: str, /) -> bool:
    """Return whether a message says that the other participant has left."""
    return LEFT.fullmatch(message) is not None
