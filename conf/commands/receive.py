"""`conf receive`: accept calls and show the participants."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from conf.atomic_write import check_writable
from conf.commands import Terminal
from conf.commands.support.arguments import add_json, add_listen, add_seconds, pairing_code
from conf.commands.support.call_table import call_table
from conf.commands.support.interruption import until_interrupted
from conf.commands.support.sound import add_no_sound, add_sound_output
from conf.errors import AudioError, FileFormatError, GraphicsError

if TYPE_CHECKING:
    from conf.protocol.call_report import CallReport
    from conf.receiver.pipeline import ReceiverLoop
    from conf.receiver.voice.call_sound import CallSound
    from conf.receiver.voice.voice_mixer import VoiceMixer
    from conf.render.window import Window
    from conf.transport.udp import UdpSocket

HELP = "accept calls, show the participants and play their voices"
WINDOW_SIZE = (1280, 720)
HEADLESS_SIZE = (640, 480)
WINDOW_FPS = 60.0
HEADLESS_FPS = 30.0


@dataclass(frozen=True)
class ReceiveOptions:
    """How the participants are shown.

    headless : MP4 or AVI file to draw into instead of a window
    image : JPG file of the last image, for headless drawing
    on_event : called when a caller comes or goes
    on_report : called at the end, with a line about each file written
    sound : play the callers' voices; speaker : number or name of the loudspeaker, None for the default
    """

    headless: Path | None = None
    image: Path | None = None
    seconds: float | None = None
    on_event: Callable[[str], None] | None = None
    on_report: Callable[[str], None] = lambda text: None
    sound: bool = True
    speaker: str | None = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_listen(parser)
    parser.add_argument("--code", type=pairing_code, help="the code that callers need (default: a new one each time)")
    parser.add_argument("--face", type=Path, metavar="FILE", help="another face: a mesh with its PPC beside it")
    parser.add_argument("--headless", type=Path, metavar="OUT.mp4", help="no window: record this clip, MP4 or AVI")
    add_sound_output(parser)
    add_no_sound(parser, "play and record no voice")
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.protocol.address import format_address
    from conf.protocol.session.pairing_code import generate_code
    from conf.transport.udp import UdpSocket

    check_before_call(options.face, options.headless)
    code = options.code or generate_code(os.urandom)
    with UdpSocket.bind(*options.listen) as socket:
        terminal.write(f"listening on {format_address(socket.address)}, code {code}")
        receive_options = ReceiveOptions(
            options.headless,
            None,
            options.seconds,
            terminal.write,
            terminal.write,
            sound=not options.no_sound,
            speaker=options.speaker,
        )
        report = receive(socket, code, receive_options, face=options.face)
    terminal.print_figures("the call", report, call_table(report))


def check_before_call(face: Path | None, headless: Path | None) -> None:
    """Raise what loading the face, opening the window and writing the clip would raise after the code has been printed.

    headless : the clip to draw into
    Raises FileFormatError, GraphicsError, RecordingError.
    """
    if face is not None:
        for path, advice in (face, "check the name"), (face.with_suffix(".ppc"), f"`conf fit {face}` makes it"):
            if not path.exists():
                raise FileFormatError(path, None, f"expected a file; {advice}")
    if headless is not None:
        from conf.output.clip_encoder import clip_format

        clip_format(headless)
        check_writable(headless)
    elif not has_display():
        from conf.render.window.glfw_window import NO_DISPLAY

        raise GraphicsError(NO_DISPLAY.format(display="not set"))


def _run(loop: ReceiverLoop, options: ReceiveOptions, should_continue: Callable[[], bool]) -> CallReport:
    """Run the loop until the time is over, should_continue is False or the user interrupts."""
    try:
        with until_interrupted() as is_uninterrupted:
            return loop.run(seconds=options.seconds, should_continue=lambda: is_uninterrupted() and should_continue())
    finally:
        for text in loop.reports:
            options.on_report(text)


def has_display() -> bool:
    """Return whether a window can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def receive(
    socket: UdpSocket,
    code: str,
    options: ReceiveOptions,
    *,
    face: Path | None = None,
    should_continue: Callable[[], bool] = lambda: True,
) -> CallReport:
    """Show the callers of a socket until the window is closed, the time is over or the user interrupts.

    Returns the figures of all calls.

    code : what callers need, as normalise_code returns it
    Raises GraphicsError, FileFormatError, RecordingError, AudioError.
    """
    import numpy as np

    from conf.audio.samples import SAMPLE_RATE
    from conf.face.loading import load_face
    from conf.output.image_writer import save_image
    from conf.output.video_writer import VideoWriter
    from conf.protocol.address import format_address
    from conf.protocol.receiver_endpoint import ReceiverEndpoint
    from conf.protocol.session.server import SessionServer
    from conf.receiver.call_display import LoopOptions
    from conf.receiver.pipeline import ReceiverLoop
    from conf.receiver.voice.call_sound import ClipSound
    from conf.receiver.voice.voice_mixer import VoiceMixer
    from conf.render.window.glfw_window import GlfwWindow
    from conf.render.window.offscreen import OffscreenWindow

    model = load_face(face)
    if model.mesh.notes and options.on_event is not None:
        options.on_event(f"{face}: {'; '.join(model.mesh.notes)}")
    endpoint = ReceiverEndpoint(SessionServer(code, os.urandom))
    idle_text = f"listening on {format_address(socket.address)}   code  {code}"
    mixer = VoiceMixer(endpoint.streams, np.random.default_rng())
    if options.headless is None:
        with GlfwWindow(*WINDOW_SIZE, "conf") as window, _open_loudspeaker(mixer, options) as sound:
            loop_options = LoopOptions(
                WINDOW_FPS, idle_text, on_event=options.on_event, draw_clock=time.perf_counter, sound=sound
            )
            loop = ReceiverLoop(window, model, endpoint, socket, loop_options)
            return _run(loop, options, should_continue)
    with OffscreenWindow(*HEADLESS_SIZE) as offscreen:
        rate = SAMPLE_RATE if options.sound else None
        with VideoWriter(options.headless, fps=HEADLESS_FPS, audio_rate=rate) as video:
            file_sound = ClipSound(mixer) if options.sound else None

            def write(window: Window, now: float) -> None:
                video.write_at(window.read, now)
                for block in file_sound.recorded(now) if file_sound else ():
                    video.write_audio(block.samples, block.timestamp)

            loop_options = LoopOptions(HEADLESS_FPS, idle_text, write, options.on_event, sound=file_sound)
            loop = ReceiverLoop(offscreen, model, endpoint, socket, loop_options)
            report = _run(loop, options, should_continue)
        if video.frames:
            options.on_report(f"saved {video.path}")
        if options.image is not None:
            options.on_report(f"saved {save_image(options.image, offscreen.read())}")
    return report


@contextmanager
def _open_loudspeaker(mixer: VoiceMixer, options: ReceiveOptions) -> Iterator[CallSound | None]:
    """Yield the sound of a window: None without a loudspeaker, which is an error only if one was asked for."""
    from conf.audio.devices import open_speaker
    from conf.receiver.voice.call_sound import LoudspeakerSound

    if not options.sound:
        yield None
        return
    try:
        output = open_speaker(options.speaker)
    except AudioError as error:
        if options.speaker is not None:
            raise
        if options.on_event:
            options.on_event(f"no sound is played: {error}")
        yield None
        return
    with LoudspeakerSound(mixer, output) as sound:
        yield sound
