"""What a call is drawn into and heard through: a window and a loudspeaker, or a clip."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from conf.atomic_write import check_writable
from conf.errors import AudioError, FileFormatError, GraphicsError

if TYPE_CHECKING:
    from conf.receiver.call_display import LoopOptions
    from conf.receiver.voice.call_sound import CallSound
    from conf.receiver.voice.voice_mixer import VoiceMixer, VoiceStream
    from conf.render.window import Window

WINDOW_SIZE = (1280, 720)
HEADLESS_SIZE = (640, 480)
WINDOW_FPS = 60.0
HEADLESS_FPS = 30.0


@dataclass(frozen=True)
class DisplayOptions:
    """How the participants are shown.

    headless : MP4 or AVI file to draw into instead of a window
    image : JPG file of the last image, for headless drawing
    on_event : called when a caller comes or goes
    on_report : called at the end, with a line about each file written
    visible : whether the window is shown at once; if not, `CallDisplay.show` shows it
    sound : play the callers' voices; speaker : number or name of the loudspeaker, None for the default
    """

    headless: Path | None = None
    image: Path | None = None
    on_event: Callable[[str], None] | None = None
    on_report: Callable[[str], None] = lambda text: None
    visible: bool = True
    sound: bool = True
    speaker: str | None = None


def has_display() -> bool:
    """Return whether a window can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


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


@contextmanager
def open_display(
    options: DisplayOptions, streams: Mapping[int, VoiceStream], *, idle_text: str = ""
) -> Iterator[tuple[Window, LoopOptions]]:
    """Open the window and the loudspeaker, or the clip, and yield what draws there.

    streams : the receiving halves of the calls, by session; idle_text : message while there is no call
    Raises GraphicsError, RecordingError, AudioError.
    """
    import numpy as np

    from conf.receiver.call_display import LoopOptions
    from conf.receiver.voice.voice_mixer import VoiceMixer

    mixer = VoiceMixer(streams, np.random.default_rng())
    if options.headless is not None:
        with _open_clip(options, options.headless, mixer, idle_text) as opened:
            yield opened
        return
    from conf.render.window.glfw_window import GlfwWindow

    with (
        GlfwWindow(*WINDOW_SIZE, "conf", visible=options.visible) as window,
        _open_loudspeaker(mixer, options) as sound,
    ):
        yield (
            window,
            LoopOptions(WINDOW_FPS, idle_text, on_event=options.on_event, draw_clock=time.perf_counter, sound=sound),
        )


@contextmanager
def _open_clip(
    options: DisplayOptions, headless: Path, mixer: VoiceMixer, idle_text: str
) -> Iterator[tuple[Window, LoopOptions]]:
    from conf.audio.samples import SAMPLE_RATE
    from conf.output.image_writer import save_image
    from conf.output.video_writer import VideoWriter
    from conf.receiver.call_display import LoopOptions
    from conf.receiver.voice.call_sound import ClipSound
    from conf.render.window.offscreen import OffscreenWindow

    with OffscreenWindow(*HEADLESS_SIZE) as offscreen:
        rate = SAMPLE_RATE if options.sound else None
        with VideoWriter(headless, fps=HEADLESS_FPS, audio_rate=rate) as video:
            sound = ClipSound(mixer) if options.sound else None

            def write(window: Window, now: float) -> None:
                video.write_at(window.read, now)
                for block in sound.recorded(now) if sound else ():
                    video.write_audio(block.samples, block.timestamp)

            yield offscreen, LoopOptions(HEADLESS_FPS, idle_text, write, options.on_event, sound=sound)
        if video.frames:
            options.on_report(f"saved {video.path}")
        if options.image is not None:
            options.on_report(f"saved {save_image(options.image, offscreen.read())}")


@contextmanager
def _open_loudspeaker(mixer: VoiceMixer, options: DisplayOptions) -> Iterator[CallSound | None]:
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
    with LoudspeakerSound(mixer, output, reopen=lambda: open_speaker(options.speaker)) as sound:
        yield sound
