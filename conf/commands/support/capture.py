"""Options for what is captured and sent, and what they open: shared by the commands that send."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import link_rate, pairing_code, positive_number
from conf.commands.support.sound import PlayedSound, add_sound_input, open_sound
from conf.errors import ConfError

if TYPE_CHECKING:
    from conf.protocol.messages import StreamParameters
    from conf.protocol.portrait.object_sender import ObjectSender
    from conf.protocol.rate_control.send_budget import RateOptions
    from conf.sender.capture.clip import Clip
    from conf.sender.capture.frame import Frame
    from conf.sender.motion_source import MotionSource
    from conf.sender.tracking.tracker import TrackedFace
    from conf.sender.voice.voice_sender import VoiceSender

    OnFrame = Callable[[Frame, TrackedFace | None], None]
    # (size of the frames, sets the neutral pose) -> what is called with each frame
    Viewer = Callable[[tuple[int, int], Callable[[], None]], AbstractContextManager[OnFrame]]

PROFILES_HELP = "live: 15 frames a second; narrow: for 2,400 bit/s; rich: 30; auto: what voice and link allow"
NO_PORTRAIT = "no image will be sent: --profile narrow or a --kbps this low leaves no room for one"
FPS = 15.0
MIN_PORTRAIT_KBPS = 3.0  # a lower cap is used up by the motion


@dataclass(frozen=True)
class CaptureOptions:
    """What is captured and sent.

    file : a clip as the camera; dpc : a recorded motion; without both the camera, by number or device
    calibrate : use the first detected face as the neutral pose
    portrait_kbps : rate for images of the person; None never sends any
    profile, kbps, voice : as in RateOptions
    sound : a file in place of the microphone; microphone : its number or name, None for the default
    """

    camera: str = "0"
    file: Path | None = None
    dpc: Path | None = None
    loop: bool = False
    calibrate: bool = False
    portrait_kbps: float | None = None
    profile: str = "auto"
    kbps: float | None = None
    voice: str = "auto"
    sound: Path | None = None
    microphone: str | None = None


def add_capture(parser: argparse.ArgumentParser, *, code_help: str) -> None:
    add = parser.add_argument
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--camera", default="0", metavar="N", help="number or device of the camera (default 0)")
    source.add_argument("--file", type=Path, metavar="CLIP", help="a clip as the camera, with its own sound")
    source.add_argument("--dpc", type=Path, metavar="FILE", help="a recorded motion instead of a face")
    add("--code", type=pairing_code, help=code_help)
    add("--profile", choices=["auto", "live", "narrow", "rich"], default="auto", help=PROFILES_HELP)
    add("--kbps", type=link_rate, metavar="N", help="never more kbit/s than this over any ten seconds, all counted")
    add("--calibrate", action="store_true", help="use the first detected face as the neutral pose")
    add("--portrait", action="store_true", help="allow images of the person to be sent (default: none ever)")
    add("--no-portrait", dest="portrait", action="store_false", help="send no image, though the settings allow it")
    add("--portrait-kbps", type=positive_number, default=4.0, metavar="N", help="rate for these images (default 4)")
    add("--loop", action="store_true", help="repeat the clip, the recorded motion or the sound")
    add_sound_input(parser)


def apply_switches(options: argparse.Namespace, terminal: Terminal) -> None:
    """Turn --portrait and --no-sound into the values of CaptureOptions, and tell if no image can be sent."""
    if options.portrait and not has_room_for_portrait(options.profile, options.kbps):
        terminal.write(NO_PORTRAIT)
    if not options.portrait:
        options.portrait_kbps = None
    if options.no_sound:
        options.voice = "off"


def has_room_for_portrait(profile: str, kbps: float | None) -> bool:
    """Return whether images can be sent with these options."""
    return profile != "narrow" and (kbps or MIN_PORTRAIT_KBPS) >= MIN_PORTRAIT_KBPS


def read_code(terminal: Terminal, who: str) -> str:
    """Return the code from CONF_CODE or from the user. who : shows the code. Raises ConfError if there is neither."""
    text = os.environ.get("CONF_CODE") or terminal.ask(f"the code that {who} shows: ")
    try:
        return pairing_code(text)
    except argparse.ArgumentTypeError as error:
        raise ConfError(f"{error}: give the one {who} shows with --code") from error


def stream_parameters(source: MotionSource) -> StreamParameters:
    """Return what the other end has to know of a source."""
    from conf.face.control_points import CONTROL_POINT_COUNT
    from conf.protocol.messages import StreamParameters

    return StreamParameters(*source.size, min(FPS, source.fps), CONTROL_POINT_COUNT, source.fapu_lengths)


def rate_options(options: CaptureOptions, *, voice: bool) -> RateOptions:
    """Return how much may be sent. voice : whether there is one"""
    from conf.protocol.rate_control.rate_levels import VoiceMode
    from conf.protocol.rate_control.send_budget import RateOptions

    mode = VoiceMode(options.voice) if voice else VoiceMode.OFF
    return RateOptions(options.profile, options.kbps, options.portrait_kbps, mode)


@contextmanager
def open_source(
    options: CaptureOptions,
    object_sender: ObjectSender | None,
    on_note: Callable[[str], None],
    *,
    viewer: Viewer | None = None,
    played: PlayedSound | None = None,
    is_camera_optional: bool = False,
) -> Iterator[tuple[MotionSource, VoiceSender | None]]:
    """Open camera, clip or recording, the tracker, and microphone or sound.

    object_sender : for images of the person, None to send none
    on_note : called with what is odd about the camera or clip, or missing, such as a microphone
    viewer : of the camera's images, opened with the source
    played : what a loudspeaker plays, whose echo is removed from the microphone's sound
    is_camera_optional : a camera that is missing is an error only when it is read
    Raises CameraError, ModelError, FileFormatError, AudioError.
    """
    from conf.sender.capture.camera import open_camera
    from conf.sender.motion.extractor import MotionExtractor
    from conf.sender.motion_source import TrackedMotionSource, open_motion_file
    from conf.sender.portrait.deferred_scheduler import DeferredPortraitScheduler
    from conf.sender.tracking.canonical_face import load_canonical_face
    from conf.sender.tracking.detector import FaceDetector
    from conf.sender.tracking.model_files import fetch_models
    from conf.sender.tracking.orientation import UprightCamera, open_upright_clip
    from conf.sender.tracking.tracker import FaceTracker

    with ExitStack() as stack:
        if options.dpc is not None:
            motion = open_motion_file(options.dpc, loop=options.loop)
            voice = _open_voice(options, None, on_note, played) if options.sound or options.microphone else None
            if voice:
                stack.callback(voice.close)
            yield motion, voice
            return
        models = fetch_models()
        source: Clip | UprightCamera
        clip = None
        if options.file:
            source = clip = stack.enter_context(
                open_upright_clip(options.file, models, loop=options.loop, is_paced=True, on_note=on_note)
            )
        else:
            camera = stack.enter_context(open_camera(options.camera, is_optional=is_camera_optional))
            source = UprightCamera(camera, FaceDetector(models), on_note=on_note)
        canonical = load_canonical_face()
        extractor = MotionExtractor(canonical, source.size)
        scheduler = DeferredPortraitScheduler(canonical, object_sender) if object_sender else None
        if options.calibrate:
            extractor.set_neutral_now()
        tracker = FaceTracker(models)
        on_frame: OnFrame | None = None
        voice = _open_voice(options, clip, on_note, played)
        if voice:
            stack.callback(voice.close)
        if viewer is not None:
            on_frame = stack.enter_context(viewer(source.size, extractor.set_neutral_now))
        yield TrackedMotionSource(source, tracker, extractor, portrait_scheduler=scheduler, on_frame=on_frame), voice


def _open_voice(
    options: CaptureOptions, clip: Clip | None, on_note: Callable[[str], None], played: PlayedSound | None
) -> VoiceSender | None:
    """Open microphone or file and prepare the voice, None if none is to be sent."""
    from conf.audio.processing import VoiceProcessor
    from conf.sender.capture.microphone import MicrophoneSource
    from conf.sender.voice.voice_sender import VoiceSender

    if options.voice == "off":
        return None
    sound = open_sound(
        clip=clip,
        clip_path=options.file,
        file=options.sound,
        loop=options.loop,
        microphone=options.microphone,
        live_frames=options.file is None and options.dpc is None,
        on_note=on_note,
    )
    if sound is None:
        return None
    if played is not None and isinstance(sound, MicrophoneSource):
        microphone = sound
        played.offset_s = lambda: microphone.offset_s
        processor = VoiceProcessor(read_played=played.read)
    else:
        processor = VoiceProcessor()
    if processor.fault:
        on_note(processor.fault)
    return VoiceSender(sound, processor)
