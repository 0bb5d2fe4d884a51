"""`conf send`: track a face and send its motion."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_json, add_seconds, address, pairing_code, positive_number
from conf.commands.support.interruption import until_interrupted
from conf.commands.support.sound import add_no_sound, add_sound_input, open_sound
from conf.errors import ConfError

if TYPE_CHECKING:
    from conf.protocol.portrait.object_sender import ObjectSender
    from conf.sender.capture.clip import Clip
    from conf.sender.motion_source import MotionSource
    from conf.sender.pipeline import SenderStatus
    from conf.sender.voice.voice_sender import VoiceSender

HELP = "track a face and send its motion, with the voice"
PROFILES_HELP = "live: 15 frames a second; narrow: for 2,400 bit/s; rich: 30; auto: what voice and link allow"
FPS = 15.0
MIN_PORTRAIT_KBPS = 3.0  # a lower cap is used up by the motion


@dataclass(frozen=True)
class SendOptions:
    """What is sent and for how long.

    file : a clip as the camera; dpc : a recorded motion; without both the camera, by number or device
    calibrate : use the first detected face as the neutral pose
    preview : show the camera's image in a window
    portrait_kbps : rate for images of the person; None never sends any
    profile, kbps, voice : as in RateOptions
    sound : a file in place of the microphone; microphone : its number or name, None for the default
    """

    camera: str = "0"
    file: Path | None = None
    dpc: Path | None = None
    loop: bool = False
    seconds: float | None = None
    calibrate: bool = False
    preview: bool = False
    portrait_kbps: float | None = None
    profile: str = "auto"
    kbps: float | None = None
    voice: str = "auto"
    sound: Path | None = None
    microphone: str | None = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("receiver", type=address, metavar="HOST[:PORT]", help="where `conf receive` runs")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--camera", default="0", metavar="N", help="number or device of the camera (default 0)")
    source.add_argument("--file", type=Path, metavar="CLIP", help="a clip as the camera, with its own sound")
    source.add_argument("--dpc", type=Path, metavar="FILE", help="a recorded motion instead of a face")
    add("--code", type=pairing_code, help="the code that the receiver shows (default: CONF_CODE, or asked for)")
    add("--profile", choices=["auto", "live", "narrow", "rich"], default="auto", help=PROFILES_HELP)
    add(
        "--kbps",
        type=positive_number,
        metavar="N",
        help="never more kbit/s than this over any ten seconds, all counted",
    )
    add("--calibrate", action="store_true", help="use the first detected face as the neutral pose")
    add("--preview", action="store_true", help="show the camera's image in a window; N: this is my neutral face")
    add("--portrait", action="store_true", help="allow images of the person to be sent (default: none ever)")
    add("--no-portrait", dest="portrait", action="store_false", help="send no image, though the settings allow it")
    add("--portrait-kbps", type=positive_number, default=4.0, metavar="N", help="rate for these images (default 4)")
    add("--loop", action="store_true", help="repeat the clip, the recorded motion or the sound")
    add_sound_input(parser)
    add_no_sound(parser, "send no voice")
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    code = options.code or _read_code(terminal)
    if options.portrait and (options.profile == "narrow" or (options.kbps or MIN_PORTRAIT_KBPS) < MIN_PORTRAIT_KBPS):
        terminal.write("no image will be sent: --profile narrow or a --kbps this low leaves no room for one")
    if not options.portrait:
        options.portrait_kbps = None
    if options.no_sound:
        options.voice = "off"
    send_options = SendOptions(**{field.name: getattr(options, field.name) for field in fields(SendOptions)})
    with terminal.status_line() as show:
        status = send(
            options.receiver,
            code,
            send_options,
            on_status=lambda status: show(_status_text(status)),
            on_note=terminal.write,
        )
    terminal.print_figures("sent", status)


def _read_code(terminal: Terminal) -> str:
    """Return the code from CONF_CODE or from the user. Raises ConfError if there is neither."""
    text = os.environ.get("CONF_CODE") or terminal.ask("the code that the receiver shows: ")
    try:
        return pairing_code(text)
    except argparse.ArgumentTypeError as error:
        raise ConfError(f"{error}: give the one the receiver shows with --code") from error


def _status_text(status: SenderStatus) -> str:
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
    return ", ".join([*parts, f"tracker {status.tracker_ms_median:.1f} ms"])


def send(
    receiver: tuple[str, int],
    code: str,
    options: SendOptions,
    *,
    on_status: Callable[[SenderStatus], None] | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> SenderStatus:
    """Send until the clip ends, the time is over or the user interrupts.

    code : what the receiver shows, as normalise_code returns it
    on_note : called with what is odd about the camera or clip, or missing, such as a microphone
    Raises CameraError, ModelError, NetworkError, FileFormatError, AudioError.
    """
    from conf.face.control_points import CONTROL_POINT_COUNT
    from conf.protocol.messages import StreamParameters
    from conf.protocol.portrait.object_sender import ObjectSender
    from conf.protocol.rate_control.rate_levels import VoiceMode
    from conf.protocol.rate_control.send_budget import RateOptions
    from conf.protocol.sender_connection import SenderConnection
    from conf.protocol.session.client import SenderSession
    from conf.sender.pipeline import SenderLoop
    from conf.transport.udp import UdpSocket

    object_sender = ObjectSender() if options.portrait_kbps else None
    with UdpSocket.open_to(*receiver) as socket, _open_source(options, object_sender, on_note) as opened:
        source, voice = opened
        parameters = StreamParameters(*source.size, min(FPS, source.fps), CONTROL_POINT_COUNT, source.fapu_lengths)
        now = time.monotonic()
        assert socket.remote is not None
        session = SenderSession(code, socket.remote, os.urandom, now)
        mode = VoiceMode(options.voice) if voice else VoiceMode.OFF
        rate = RateOptions(options.profile, options.kbps, options.portrait_kbps, mode)
        connection = SenderConnection(session, parameters, now, rate=rate, portrait=object_sender)
        loop = SenderLoop(source, connection, socket, voice=voice)
        with until_interrupted() as should_continue:
            return loop.run(seconds=options.seconds, on_status=on_status, should_continue=should_continue)


@contextmanager
def _open_source(
    options: SendOptions, object_sender: ObjectSender | None, on_note: Callable[[str], None]
) -> Iterator[tuple[MotionSource, VoiceSender | None]]:
    from conf.sender.capture.camera import open_camera
    from conf.sender.motion.extractor import MotionExtractor
    from conf.sender.motion_source import TrackedMotionSource, open_motion_file
    from conf.sender.portrait.scheduler import PortraitScheduler
    from conf.sender.tracking.canonical_face import load_canonical_face
    from conf.sender.tracking.detector import FaceDetector
    from conf.sender.tracking.model_files import fetch_models
    from conf.sender.tracking.orientation import UprightCamera, open_upright_clip
    from conf.sender.tracking.tracker import FaceTracker

    with ExitStack() as stack:
        if options.dpc is not None:
            motion = open_motion_file(options.dpc, loop=options.loop)
            voice = _open_voice(options, None, on_note) if options.sound or options.microphone else None
            if voice:
                stack.callback(voice.close)
            yield motion, voice
            return
        models = fetch_models()
        source: Clip | UprightCamera
        clip = None
        if options.file:
            source = clip = stack.enter_context(
                open_upright_clip(options.file, models, loop=options.loop, on_note=on_note)
            )
        else:
            camera = stack.enter_context(open_camera(options.camera))
            source = UprightCamera(camera, FaceDetector(models), on_note=on_note)
        canonical = load_canonical_face()
        extractor = MotionExtractor(canonical, source.size)
        scheduler = PortraitScheduler(canonical, object_sender) if object_sender else None
        if options.calibrate:
            extractor.set_neutral_now()
        tracker, on_frame = FaceTracker(models), None
        voice = _open_voice(options, clip, on_note)
        if voice:
            stack.callback(voice.close)
        if options.preview:
            from conf.commands.support.preview import Preview

            on_frame = stack.enter_context(Preview(source.size, on_neutral=extractor.set_neutral_now)).show
        yield TrackedMotionSource(source, tracker, extractor, portrait_scheduler=scheduler, on_frame=on_frame), voice


def _open_voice(options: SendOptions, clip: Clip | None, on_note: Callable[[str], None]) -> VoiceSender | None:
    """Open microphone or file and prepare the voice, None if none is to be sent."""
    from conf.audio.processing import VoiceProcessor
    from conf.sender.voice.voice_sender import VoiceSender

    if options.voice == "off":
        return None
    sound = open_sound(
        clip=clip,
        clip_path=options.file,
        file=options.sound,
        loop=options.loop,
        microphone=options.microphone,
        on_note=on_note,
    )
    if sound is None:
        return None
    processor = VoiceProcessor()
    if processor.fault:
        on_note(processor.fault)
    return VoiceSender(sound, processor)
