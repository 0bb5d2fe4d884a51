"""Run one end of a call of two as `conf call` does, and log every frame captured and every image drawn.

    python tools/bench/call_end_probe.py listen CODE SECONDS MOTION.dpc [--sound FILE] [--speaker N|NAME] [--fps N]
    python tools/bench/call_end_probe.py HOST:PORT CODE SECONDS MOTION.dpc [--sound FILE] [--speaker N|NAME] [--fps N]

Prints JSON, one object a line: the address it listens on, then each second the figures of what it receives, the frames
it has captured, the images it has drawn and what the loudspeaker did (call_probe.py, sound_probe.py). All times are of
the machine's monotonic clock, which both processes share. Everything is drawn, with buttons, but not recorded.
Used by tools/network/soak.py.
"""

import argparse
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.call import composer
from conf.commands import call
from conf.commands.support.capture import CaptureOptions
from conf.commands.support.display import HEADLESS_SIZE, DisplayOptions
from conf.errors import NetworkError
from conf.protocol import send_leg
from conf.protocol.receive_leg import ReceiveLeg
from conf.receiver.call_display import LoopOptions
from conf.render.window.offscreen import OffscreenWindow
from conf.sender import face_capture
from conf.sender.face_capture import CapturedMotion
from tools.bench.call_probe import LOG_INTERVAL_S, WatchedMotion, log, memory_kb, sent_since_log, split_address
from tools.bench.sound_probe import WatchedSound

LISTENING = "listening on "
DRAWN_FPS = 10.0
FRAMES: list[tuple[float, float]] = []  # (captured at, time on the source's clock), since the last log
SOUNDS: list[WatchedSound] = []  # one, if the voice is played


class WatchedCapture(face_capture.FaceCapture):
    """A capture that logs when each frame was captured."""

    def pop(self) -> CapturedMotion | None:
        """Return what the last step has captured, once."""
        captured = super().pop()
        if captured is not None:
            FRAMES.append((time.monotonic(), captured.timestamp))
        return captured


class WatchedComposer(composer.CallComposer):
    """A composer that logs when each image was finished and what it showed."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **(options | {"is_interactive": True}))
        self._pictures: list[tuple[float, float, float]] = []
        self._log_due = 0.0

    def present(self, now: float) -> None:
        """Present the frame and log it: (finished at, playhead, s the playhead is past the newest frame)."""
        super().present(now)
        self._window.ctx.finish()
        at = time.monotonic()
        for leg in self._endpoint.streams.values():
            playhead, newest = leg.motion.buffer.playhead, leg.motion.buffer.newest
            if newest is not None:
                self._pictures.append((at, float(playhead), max(0.0, float(playhead) - newest)))
        for sound in SOUNDS:
            sound.on_frames_drawn([self._frame], at)
        if at >= self._log_due:
            self._log_due = at + LOG_INTERVAL_S
            self._log(at)

    def _log(self, at: float) -> None:
        endpoint, frames = self._endpoint, FRAMES[:]
        del FRAMES[: len(frames)]
        sounds = SOUNDS[0].figures() if SOUNDS else {}
        log(
            at=at,
            memory_kb=memory_kb(),
            calls=endpoint._calls,
            frames_sent=endpoint.outbound.frames_sent,
            frames=frames,
            sent=sent_since_log(),
            pictures=self._pictures,
            **sounds,
            **asdict(endpoint.snapshot(at)),
        )
        self._pictures = []


def hold(
    options: call.CallOptions, *, speaker: str | None = None, fps: float = DRAWN_FPS, began: float | None = None
) -> None:
    """Hold one end of a call. speaker : what plays the voice, None for none; fps : frames drawn a second

    Raises NetworkError.
    """

    @contextmanager
    def open_display(
        _options: DisplayOptions, streams: Mapping[int, ReceiveLeg]
    ) -> Iterator[tuple[OffscreenWindow, LoopOptions]]:
        sound = WatchedSound(streams, speaker) if speaker is not None else None
        if sound:
            SOUNDS.append(sound)
        with OffscreenWindow(*HEADLESS_SIZE) as window, sound.output if sound else nullcontext() as output:
            yield window, LoopOptions(fps, sound=output)

    face_capture.FaceCapture = WatchedCapture  # type: ignore[misc]
    send_leg.OutboundMotion = WatchedMotion  # type: ignore[attr-defined]
    composer.CallComposer = WatchedComposer  # type: ignore[misc]
    call.open_display = open_display  # type: ignore[attr-defined, assignment]
    call.call(options, began=time.monotonic() if began is None else began)


def main() -> None:
    """Hold one end of a call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("remote", help="HOST:PORT, or `listen`")
    parser.add_argument("code")
    parser.add_argument("seconds", type=float)
    parser.add_argument("motion", type=Path)
    parser.add_argument("--sound", type=Path, help="send the sound of a file")
    parser.add_argument("--speaker", help="play the voice: a number or name as of `conf devices`, or null")
    parser.add_argument("--fps", type=float, default=DRAWN_FPS, help="frames drawn a second")
    parser.add_argument("--kbps", type=float, help="send no more than this")
    options = parser.parse_args()
    capture = CaptureOptions(
        dpc=options.motion, loop=True, sound=options.sound, voice="auto" if options.sound else "off", kbps=options.kbps
    )
    end = call.CallOptions(
        capture=capture,
        display=DisplayOptions(),
        remote=None if options.remote == "listen" else split_address(options.remote),
        listen=("127.0.0.1", 0),
        code=options.code,
        seconds=options.seconds,
        on_ready=lambda text: log(listening=text.removeprefix(LISTENING).split(",")[0]),
        on_note=lambda text: print(text, file=sys.stderr),
    )
    try:
        hold(end, speaker=options.speaker, fps=options.fps)
    except NetworkError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
