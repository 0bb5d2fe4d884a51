"""`conf call`: a call of two, face and voice both ways in one window."""

from __future__ import annotations

import argparse
import gc
import getpass
import os
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_face, add_headless, add_json, add_listen, add_seconds
from conf.commands.support.call_table import media_text
from conf.commands.support.capture import (
    FPS,
    CaptureOptions,
    add_capture,
    apply_switches,
    open_source,
    rate_options,
    stream_parameters,
)
from conf.commands.support.display import DisplayOptions, check_before_call, open_display
from conf.commands.support.garbage import frozen_memory
from conf.commands.support.heads import add_head, add_proportions, head_loader, head_number
from conf.commands.support.interruption import until_interrupted
from conf.commands.support.relay_route import (
    LOCAL_NETWORK,
    RelayRoute,
    add_relay,
    call_target,
    code_to_call,
    describe_waiting,
    open_at,
    open_to,
    route_of,
    waiting,
)
from conf.commands.support.sound import PlayedSound, add_no_sound, add_sound_output
from conf.errors import ConfError

if TYPE_CHECKING:
    from conf.call.early_exchange import EarlyExchange
    from conf.call.figures import CallFigures
    from conf.call.loop import CallLoop
    from conf.call.self_view import SelfView
    from conf.call.shared_objects import SharedObjectSender
    from conf.face.deformation.face_model import FaceModel
    from conf.protocol.call_endpoint import CallEndpoint
    from conf.receiver.call_display import LoopOptions
    from conf.render.window import Window
    from conf.sender.face_capture import FaceCapture
    from conf.sender.voice.voice_sender import VoiceSender
    from conf.transport.interface import Transport

HELP = "call somebody, or wait to be called: face and voice both ways"
CODE_HELP = (
    "calling: the code that the other end shows (default: CONF_CODE, or asked for); "
    "listening: the code to use (default: CONF_CODE, or a new one)"
)
BOTH = "give the HOST or the code to call, or --listen HOST:PORT to be called, not both"
NO_CALL = "there was no call"
MAX_OBJECTS = 64  # of one's own portrait that wait to be drawn in the corner
IMPORT_DELAY_S = 2.0  # from the loop's start until what portraits need is imported: a third of a second of CPU time
# What a call is announced with before the camera is open.
CAMERA_SIZE = (640, 480)
FAPU = (6.64, 5.035, 2.881, 5.18, 1.024)  # of a mean face, cm


@dataclass(frozen=True)
class CallOptions:
    """One end of a call.

    capture : what is sent; display : where the other participant is drawn and heard
    remote : host and port to call, or what call_target returns for a relay; None to wait for a call
    listen : where to wait for a call, None to wait over a relay; route : the way over a relay
    code : as normalise_code returns it; name : shown at the other end
    portrait : whether images of the person may be sent from the start
    face : mesh on which the other participant is drawn, None for the shipped heads
    head : number of the head that this end has chosen, 0 for none; proportions : whether heads take on their person's
    on_ready : called with the address and the code, once a call can come
    """

    capture: CaptureOptions
    display: DisplayOptions
    remote: tuple[str, int] | str | None
    listen: tuple[str, int] | None
    code: str
    name: str = ""
    portrait: bool = False
    face: Path | None = None
    head: int = 0
    proportions: bool = True
    seconds: float | None = None
    route: RelayRoute = LOCAL_NETWORK
    on_ready: Callable[[str], None] = lambda text: None
    on_note: Callable[[str], None] = lambda text: None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "remote",
        nargs="?",
        type=call_target,
        metavar="CODE|HOST[:PORT]",
        help="the code that the other end shows, or its number, or where `conf call --listen` runs; nothing to wait "
        "to be called",
    )
    add_listen(parser)
    add_relay(parser)
    parser.add_argument("--name", default=None, help="your name, shown at the other end (default: the login name)")
    add_capture(parser, code_help=CODE_HELP)
    add_head(parser)
    add_face(parser)
    add_proportions(parser)
    add_headless(parser)
    parser.add_argument(
        "--show-when-connected", action="store_true", help="open no window before the other participant is there"
    )
    add_sound_output(parser)
    add_no_sound(parser, "neither send nor play voice")
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    began = time.monotonic()
    if options.remote and options.listen:
        raise ConfError(BOTH)
    check_before_call(options.face, options.headless)
    portrait_kbps = options.portrait_kbps  # images may be allowed later, with a key
    apply_switches(options, terminal)
    options.portrait_kbps = portrait_kbps
    call_options = CallOptions(
        capture=CaptureOptions(**{field.name: getattr(options, field.name) for field in fields(CaptureOptions)}),
        display=DisplayOptions(
            options.headless,
            on_event=terminal.write,
            on_report=terminal.write,
            sound=not options.no_sound,
            speaker=options.speaker,
            visible=not options.show_when_connected,
        ),
        remote=options.remote,
        listen=options.listen,
        code=_code(options, terminal),
        name=login_name() if options.name is None else options.name,
        portrait=options.portrait,
        face=options.face,
        head=head_number(options.head),
        proportions=not options.no_proportions,
        seconds=options.seconds,
        route=route_of(options),
        on_ready=terminal.write,
        on_note=terminal.write,
    )
    figures = call(call_options, began=began)
    terminal.print_figures("the call", figures, figures_text(figures))


def login_name() -> str:
    """Return the name of the user's account, "" if it has none."""
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return ""


def _code(options: argparse.Namespace, terminal: Terminal) -> str:
    """Return the code of the call, "" for a new one. Raises ConfError."""
    if options.remote:
        return code_to_call(options.remote, options.code, terminal, "the other end")
    return options.code or _code_to_show()


def _code_to_show() -> str:
    """Return the code of who waits for a call: CONF_CODE, or "" for a new one. Raises ConfError."""
    from conf.protocol.session.pairing_code import normalise_code

    text = os.environ.get("CONF_CODE")
    try:
        return normalise_code(text) if text else ""
    except ValueError as error:
        raise ConfError(f"CONF_CODE: {error}") from error


@dataclass(frozen=True)
class _End:
    """One end of a call without its window: what is captured, sent and received."""

    socket: Transport
    endpoint: CallEndpoint
    objects: SharedObjectSender
    self_view: SelfView
    capture: FaceCapture
    voice: VoiceSender | None


def call(options: CallOptions, *, began: float) -> CallFigures:
    """Hold one call until somebody hangs up, a clip ends, the time is over or the user interrupts.

    Who calls shakes hands while the slow packages are being imported.

    began : when the command was started, on the monotonic clock
    Raises NetworkError, CameraError, ModelError, FileFormatError, AudioError, GraphicsError, RecordingError.
    """
    from conf.call.shared_objects import SharedObjectSender

    with ExitStack() as stack:
        transport, code = _open_transport(options)
        socket = stack.enter_context(transport)
        options = replace(options, code=code)
        made: deque[bytes] = deque(maxlen=MAX_OBJECTS)
        objects, played = SharedObjectSender(on_object=made.append), PlayedSound()
        endpoint = _endpoint(options, socket, objects)
        with _connecting(socket, endpoint) as early:
            from conf.call.self_view import SelfView
            from conf.face.prepared_face import prepared_face
            from conf.sender.face_capture import CaptureMode, FaceCapture

            self_view = SelfView(made)
            source, voice = stack.enter_context(
                open_source(
                    options.capture,
                    objects,
                    options.on_note,
                    viewer=lambda *_: nullcontext(self_view.show),
                    played=played if options.display.sound and options.display.headless is None else None,
                    is_camera_optional=True,
                )
            )
            endpoint.outbound.parameters = stream_parameters(source)
            model = prepared_face(options.face)
            window, drawing = stack.enter_context(open_display(options.display, endpoint.streams))
            import_module("conf.call.composer")  # slow, and lost datagrams of the handshake are repeated here
        if model.mesh.notes:
            options.on_note(f"{options.face}: {'; '.join(model.mesh.notes)}")
        played.sound = drawing.sound
        capture = FaceCapture(source, endpoint.outbound.profile.fps, mode=CaptureMode.PREVIEW)
        end = _End(socket, endpoint, objects, self_view, capture, voice)
        loop = _hold(options, end, window, model, drawing)
        return _figures(end, loop, began, None if early is None else early.connected_at)


def _open_transport(options: CallOptions) -> tuple[Transport, str]:
    """Return what carries the call, and its code. Raises NetworkError."""
    if options.remote:
        return open_to(options.remote, options.route, options.code), options.code
    return open_at(options.listen, options.route, options.code)


def _endpoint(options: CallOptions, socket: Transport, objects: SharedObjectSender) -> CallEndpoint:
    from conf.face.control_points import CONTROL_POINT_COUNT
    from conf.protocol.call_endpoint import CallEndpoint
    from conf.protocol.messages import StreamParameters

    return CallEndpoint(
        code=options.code,
        parameters=StreamParameters(*CAMERA_SIZE, FPS, CONTROL_POINT_COUNT, FAPU),
        now=time.monotonic(),
        random=os.urandom,
        remote=socket.remote,
        rate=rate_options(options.capture, voice=options.capture.voice != "off"),
        portrait=objects,
        name=options.name,
        head=options.head,
    )


def _hold(options: CallOptions, end: _End, window: Window, model: FaceModel, drawing: LoopOptions) -> CallLoop:
    """Run the loop of a call, to its end, in a window."""
    from conf.call.capture_thread import CaptureThread
    from conf.call.composer import CallComposer
    from conf.call.controls import LocalState
    from conf.call.loop import CallLoop, LocalEnd
    from conf.receiver.call_display import CallDisplay
    from conf.receiver.heads.participant_heads import HeadOptions

    is_waiting = end.socket.remote is None
    state = LocalState(portrait=options.portrait, has_microphone=end.voice is not None)
    thread = CaptureThread(end.capture)
    later = Timer(0.0 if is_waiting else IMPORT_DELAY_S, _import_rest)
    composer = CallComposer(
        window,
        model,
        end.endpoint,
        state,
        end.self_view,
        waiting=waiting(end.socket, options.route, options.remote, options.code if is_waiting else ""),
        has_face=lambda: thread.has_face,
        path=lambda: loop.path,
        draw_clock=drawing.draw_clock,
        sound=drawing.sound,
        is_interactive=options.display.headless is None,
        heads=HeadOptions(head_loader(options.face), proportions=options.proportions),
        own_head=options.head,
    )
    display = CallDisplay(window, composer, drawing)
    local = LocalEnd(thread, state, end.objects, end.self_view, end.voice)
    loop = CallLoop(end.endpoint, end.socket, local, display=display, sound=drawing.sound)
    try:
        later.start()
        with thread, frozen_memory(), until_interrupted() as should_continue:
            if is_waiting:
                later.join()
                options.on_ready(f"{describe_waiting(end.socket, options.route)}, code {options.code}")
            loop.run(seconds=options.seconds, should_continue=should_continue)
    finally:
        later.cancel()
        display.hide()
        loop.close(time.monotonic())
        display.close()
        for text in display.reports:
            options.display.on_report(text)
    return loop


def _import_rest() -> None:
    """Import what portraits and recordings need, so that no frame has to wait for it later, nor for its collection."""
    from conf.receiver import participant_grid, viewer_controls
    from conf.sender.portrait import deferred_scheduler

    viewer_controls.import_recording()
    participant_grid.import_portraits()
    deferred_scheduler.import_portraits()
    gc.freeze()  # these modules too; see frozen_memory


def _figures(end: _End, loop: CallLoop, began: float, early_at: float | None) -> CallFigures:
    """Return the figures of a call. early_at : when there was a connection, if that was before the loop began"""
    from conf.call.figures import CallTimes, call_figures

    times = CallTimes(began, loop.connected_at if early_at is None else early_at, loop.drawn_at)
    return call_figures(
        end.endpoint,
        end.capture,
        times,
        time.monotonic(),
        name=loop.peer_name,
        path=loop.path,
        path_name=end.socket.path_name,
    )


@contextmanager
def _connecting(socket: Transport, endpoint: CallEndpoint) -> Iterator[EarlyExchange | None]:
    """Exchange datagrams while the block runs, if this end calls."""
    from conf.call.early_exchange import EarlyExchange
    from conf.transport.exchange import DatagramExchange

    if socket.remote is None:
        yield None
        return
    with EarlyExchange(socket, DatagramExchange(socket, endpoint), lambda now: endpoint.status(now).connected) as early:
        yield early


def figures_text(figures: CallFigures, /) -> str:
    """Return the figures of a call as lines for the user."""
    sent, received = figures.sent, figures.received
    if not figures.connected_s:
        return NO_CALL
    lines = [
        f"connected for {figures.connected_s:,.1f} s" + (f", path: {figures.path}" if figures.path else ""),
        f"sent      {sent.frames_sent:,} frames, {sent.wire_bytes:,} B, {sent.wire_kbps:,.1f} kbit/s",
        f"received  {received.frames_received:,} frames, {received.wire_bytes:,} B, {received.wire_kbps:,.1f} kbit/s",
        f"          of these {media_text(received.media_bytes)}",
    ]
    if sent.round_trip_ms is not None:
        lines.append(f"round trip {sent.round_trip_ms:.0f} ms, loss {sent.loss_percent or 0:.1f} % of what was sent")
    return "\n".join(lines)
