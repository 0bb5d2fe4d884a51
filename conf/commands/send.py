"""`conf send`: track a face and send its motion."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_json, add_seconds
from conf.commands.support.capture import (
    CaptureOptions,
    add_capture,
    apply_switches,
    open_source,
    rate_options,
    stream_parameters,
)
from conf.commands.support.garbage import frozen_memory
from conf.commands.support.heads import add_head, head_number
from conf.commands.support.interruption import until_interrupted
from conf.commands.support.relay_route import (
    LOCAL_NETWORK,
    RelayRoute,
    add_relay,
    call_target,
    code_to_call,
    open_to,
    route_of,
)
from conf.commands.support.sound import MuteSwitch, add_no_sound
from conf.commands.support.terminal_keys import terminal_keys

if TYPE_CHECKING:
    from conf.commands.support.capture import OnFrame
    from conf.sender.pipeline import SenderStatus

HELP = "track a face and send its motion, with the voice"
VOICE_TEXTS = {"muted": "muted", "no_room": "no room for voice"}  # by SenderStatus.voice
MUTE_KEY = "m"
MUTE_HINT = "M mutes the microphone, and turns it on again"


@dataclass(frozen=True)
class SendOptions(CaptureOptions):
    """What is sent and for how long.

    preview : show the camera's image in a window; head : number of the head to be drawn with, 0 for a free one
    route : the way over a relay, for a receiver that is named by a code
    """

    head: int = 0
    seconds: float | None = None
    preview: bool = False
    route: RelayRoute = LOCAL_NETWORK


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "receiver",
        type=call_target,
        metavar="CODE|HOST[:PORT]",
        help="the code that the receiver shows, or its number, or where `conf receive --listen` runs",
    )
    add_relay(parser)
    add_capture(parser, code_help="the code that the receiver shows (default: CONF_CODE, or asked for)")
    parser.add_argument(
        "--preview", action="store_true", help="show the camera's image in a window; N: my neutral face, M: mute"
    )
    add_head(parser)
    add_no_sound(parser, "send no voice")
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    options.head = head_number(options.head)
    code = code_to_call(options.receiver, options.code, terminal, "the receiver")
    apply_switches(options, terminal)
    options.route = route_of(options)
    send_options = SendOptions(**{field.name: getattr(options, field.name) for field in fields(SendOptions)})
    with terminal.status_line() as show:
        status = send(
            options.receiver,
            code,
            send_options,
            on_status=lambda status: show(_status_text(status, over_relay=isinstance(options.receiver, str))),
            on_note=terminal.write,
        )
    terminal.print_figures("sent", status)


def _status_text(status: SenderStatus, *, over_relay: bool = False) -> str:
    """Return the line about the call. over_relay : whether it began there, so that its path is worth a word"""
    link = status.link
    if not link.connected:
        return status.note or "calling"
    if link.stopped:
        return "no reply for 10 s: not sending; trying again now and then"
    parts = [status.note] if status.note not in ("", "connected") else []
    parts += ["face" if status.face else "no face: looking for one", f"{link.profile}, {status.wire_kbps:.1f} kbit/s"]
    parts.append(f"{status.wire_bytes_per_frame:.0f} B a frame with headers, {status.frames_sent} frames")
    if link.round_trip_ms is not None:
        parts.append(f"round trip {link.round_trip_ms:.0f} ms, loss {link.loss_percent or 0:.1f} %")
        parts.append(f"jitter {link.jitter_ms or 0:.0f} ms")
    parts += [VOICE_TEXTS[status.voice]] if status.voice in VOICE_TEXTS else []
    parts += [status.path] if over_relay and status.path else []
    return ", ".join([*parts, f"tracker {status.tracker_ms_median:.1f} ms"])


def send(
    receiver: tuple[str, int] | str,
    code: str,
    options: SendOptions,
    *,
    on_status: Callable[[SenderStatus], None] | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> SenderStatus:
    """Send until the clip ends, the time is over or the user interrupts.

    receiver : host and port, or what call_target returns for a relay
    code : what the receiver shows, as normalise_code returns it
    on_note : called with what is odd about the camera or clip, or missing, such as a microphone
    Raises CameraError, ModelError, NetworkError, FileFormatError, AudioError.
    """
    from conf.protocol.portrait.object_sender import ObjectSender
    from conf.protocol.sender_connection import SenderConnection
    from conf.protocol.session.client import SenderSession
    from conf.sender.pipeline import SenderLoop
    from conf.sender.portrait.deferred_scheduler import import_portraits

    object_sender = ObjectSender() if options.portrait_kbps else None
    if object_sender:
        import_portraits()
    mute = MuteSwitch()
    viewer = partial(_preview, mute) if options.preview else None
    with (
        open_to(receiver, options.route, code) as socket,
        open_source(options, object_sender, on_note, viewer=viewer) as (source, voice),
    ):
        now = time.monotonic()
        assert socket.remote is not None
        session = SenderSession(code, socket.remote, os.urandom, now)
        rate = rate_options(options, voice=voice is not None)
        connection = SenderConnection(
            session, stream_parameters(source), now, rate=rate, portrait=object_sender, head=options.head
        )
        loop = SenderLoop(source, connection, socket, voice=voice)
        mute.voice = voice
        with frozen_memory(), until_interrupted() as is_uninterrupted, terminal_keys() as read_keys:
            if read_keys and voice:
                on_note(MUTE_HINT)

            def should_continue() -> bool:
                for key in read_keys() if read_keys else "":
                    if key.lower() == MUTE_KEY:
                        mute.toggle()
                return is_uninterrupted()

            return loop.run(seconds=options.seconds, on_status=on_status, should_continue=should_continue)


@contextmanager
def _preview(mute: MuteSwitch, size: tuple[int, int], on_neutral: Callable[[], None]) -> Iterator[OnFrame]:
    from conf.commands.support.preview import Preview

    with Preview(size, mute, on_neutral=on_neutral) as preview:
        yield preview.show
