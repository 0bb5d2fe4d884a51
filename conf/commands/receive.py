"""`conf receive`: accept calls and show the participants."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_face, add_headless, add_json, add_listen, add_seconds, pairing_code
from conf.commands.support.call_table import call_table
from conf.commands.support.display import DisplayOptions, check_before_call, open_display
from conf.commands.support.garbage import frozen_memory
from conf.commands.support.heads import add_proportions, head_loader
from conf.commands.support.interruption import until_interrupted
from conf.commands.support.relay_route import add_relay, describe_waiting, open_at, route_of
from conf.commands.support.sound import add_no_sound, add_sound_output

if TYPE_CHECKING:
    from conf.protocol.call_report import CallReport
    from conf.receiver.pipeline import ReceiverLoop
    from conf.transport.interface import Transport

HELP = "accept calls, show the participants and play their voices"


@dataclass(frozen=True)
class ReceiveOptions(DisplayOptions):
    """How the participants are shown, and for how long.

    waiting : where the receiver waits to be called, in words
    proportions : whether heads take on those of their participants
    """

    waiting: str = ""
    seconds: float | None = None
    proportions: bool = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_listen(parser)
    add_relay(parser)
    parser.add_argument("--code", type=pairing_code, help="the code that callers need (default: a new one each time)")
    add_face(parser)
    add_proportions(parser)
    add_headless(parser)
    add_sound_output(parser)
    add_no_sound(parser, "play and record no voice")
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    check_before_call(options.face, options.headless)
    route = route_of(options)
    socket, code = open_at(options.listen, route, options.code or "")
    with socket:
        waiting = describe_waiting(socket, route)
        terminal.write(f"{waiting}, code {code}")
        receive_options = ReceiveOptions(
            options.headless,
            on_event=terminal.write,
            on_report=terminal.write,
            sound=not options.no_sound,
            speaker=options.speaker,
            waiting=waiting,
            seconds=options.seconds,
            proportions=not options.no_proportions,
        )
        report = receive(socket, code, receive_options, face=options.face)
    terminal.print_figures("the call", report, call_table(report))


def receive(
    socket: Transport,
    code: str,
    options: ReceiveOptions,
    *,
    face: Path | None = None,
    should_continue: Callable[[], bool] = lambda: True,
) -> CallReport:
    """Show the callers of a transport until the window is closed, the time is over or the user interrupts.

    Returns the figures of all calls.

    code : what callers need, as normalise_code returns it
    Raises GraphicsError, FileFormatError, RecordingError, AudioError.
    """
    from conf.face.prepared_face import prepared_face
    from conf.protocol.receiver_endpoint import ReceiverEndpoint
    from conf.protocol.session.server import SessionServer
    from conf.receiver.heads.participant_heads import HeadOptions
    from conf.receiver.participant_grid import import_portraits
    from conf.receiver.pipeline import ReceiverLoop
    from conf.receiver.viewer_controls import import_recording

    model = prepared_face(face)
    if model.mesh.notes and options.on_event is not None:
        options.on_event(f"{face}: {'; '.join(model.mesh.notes)}")
    import_portraits()
    import_recording()
    endpoint = ReceiverEndpoint(SessionServer(code, os.urandom))
    idle_text = f"{options.waiting}   code  {code}"
    with open_display(options, endpoint.streams, idle_text=idle_text) as (window, loop_options):
        heads = HeadOptions(head_loader(face), proportions=options.proportions)
        loop = ReceiverLoop(window, model, endpoint, socket, replace(loop_options, heads=heads))
        return _run(loop, options, should_continue)


def _run(loop: ReceiverLoop, options: ReceiveOptions, should_continue: Callable[[], bool]) -> CallReport:
    """Run the loop until the time is over, should_continue is False or the user interrupts."""
    try:
        with frozen_memory(), until_interrupted() as is_uninterrupted:
            return loop.run(seconds=options.seconds, should_continue=lambda: is_uninterrupted() and should_continue())
    finally:
        for text in loop.reports:
            options.on_report(text)
