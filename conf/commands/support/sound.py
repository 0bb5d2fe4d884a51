"""Options for sound that several commands have, and what they open."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from conf.errors import AudioError, CameraError
from conf.settings import VOICE_CHOICES

if TYPE_CHECKING:
    from conf.audio.samples import AudioBlock
    from conf.receiver.voice.call_sound import CallSound
    from conf.sender.capture.clip import Clip
    from conf.sender.capture.sound import SoundSource
    from conf.sender.voice.voice_sender import VoiceSender

VOICE_HELP = "the voice codec (default auto: Opus, and Codec2 where the link is too slow for it)"


class PlayedSound:
    """What the loudspeaker plays, for echo cancellation, which is prepared before the loudspeaker is open.

    sound : what a call is heard through, None as long as that is not open
    offset_s : returns the clock of the frames minus that of sound devices
    """

    def __init__(self) -> None:
        self.sound: CallSound | None = None
        self.offset_s: Callable[[], float] = lambda: 0.0

    def read(self) -> AudioBlock | None:
        """Return what has been played since the last call, at its time on the clock of the frames."""
        block = self.sound.read_played() if self.sound else None
        return None if block is None else replace(block, timestamp=block.timestamp + self.offset_s())


class MuteSwitch:
    """Mutes the voice of a call. voice : None until it is open, and if there is none"""

    voice: VoiceSender | None = None

    @property
    def is_muted(self) -> bool:
        """Whether the microphone is muted."""
        return self.voice is not None and self.voice.muted

    def toggle(self) -> None:
        """Mute the microphone, or turn it on again."""
        if self.voice is not None:
            self.voice.muted = not self.voice.muted


def add_no_sound(parser: argparse.ArgumentParser, help_text: str) -> None:
    parser.add_argument("--no-sound", action="store_true", help=help_text)


def add_sound_input(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--microphone", metavar="N|NAME", help="as `conf devices` lists it (default: the system's)")
    source.add_argument("--sound", type=Path, metavar="FILE", help="the sound of a file in place of the microphone")
    parser.add_argument("--voice", choices=VOICE_CHOICES, default="auto", help=VOICE_HELP)


def add_sound_output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--speaker", metavar="N|NAME", help="as `conf devices` lists it (default: the system's)")


def open_sound(
    *,
    clip: Clip | None = None,
    clip_path: Path | None = None,
    file: Path | None = None,
    loop: bool = False,
    microphone: str | None = None,
    live_frames: bool = True,
    on_note: Callable[[str], None],
) -> SoundSource | None:
    """Open what is captured beside the frames: a file, the clip's own sound, else a microphone.

    clip, clip_path : the clip that is read as the camera, if there is one
    live_frames : the frames are a camera's, neither a clip's nor a recording's
    on_note : called with a sentence where sound is missing though nobody asked for a certain one
    Raises AudioError if the microphone that was asked for cannot be opened, CameraError if the file cannot.
    """
    from conf.sender.capture.sound import FileSoundSource

    if file is not None:
        return FileSoundSource(file, loop=loop)
    if microphone is None and clip_path is not None:
        try:
            return FileSoundSource(clip_path, clip=clip)
        except CameraError:
            return None
    from conf.sender.capture.microphone import MicrophoneSource

    try:
        return MicrophoneSource(microphone, live_frames=live_frames)
    except AudioError as error:
        if microphone is not None:
            raise
        on_note(f"no voice is sent: {error}")
        return None
