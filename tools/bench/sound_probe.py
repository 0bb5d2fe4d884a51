"""Play the voices of a call as `conf receive` does, and log what the loudspeaker, the lips and the voice do.

Part of call_probe.py. All times are of the machine's monotonic clock.
"""

import threading
import time
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from conf.audio.devices import DEVICE_RATE, Speaker, open_speaker
from conf.audio.samples import SAMPLE_RATE, Samples, level_dbfs
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.protocol.messages import MotionFrame
from conf.receiver.voice.call_sound import LoudspeakerSound
from conf.receiver.voice.voice_mixer import VoiceMixer, VoiceStream

UPPER_LIP, LOWER_LIP = (CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower"))
SEED = 1  # of the comfort noise


class CallbackClock:
    """The monotonic clock, which notes when it is read by a device's callback: in a thread that is not Python's.

    longest_s : the longest time between two callbacks since it was last set to 0
    """

    def __init__(self) -> None:
        self.longest_s = 0.0
        self._called: float | None = None

    def __call__(self) -> float:
        now = time.monotonic()
        if threading.get_ident() not in {thread.ident for thread in threading.enumerate()}:
            if self._called is not None:
                self.longest_s = max(self.longest_s, now - self._called)
            self._called = now
        return now


class WatchedMixer(VoiceMixer):
    """A mixer that logs which stream time is heard when.

    heard : (time, stream time of the voice heard then, whether it talks, level in dBFS) at the end of each block
    """

    def __init__(self, streams: Mapping[int, VoiceStream]) -> None:
        super().__init__(streams, np.random.default_rng(SEED))
        self.heard: list[tuple[float, float, bool, float]] = []

    def render(self, heard_at: float, count: int, *, output_delay_s: float = 0.0) -> Samples:
        """Render, and log the block of the first participant."""
        samples = super().render(heard_at, count, output_delay_s=output_delay_s)
        for voice in list(self.participants.values())[:1]:
            if voice._cursor is not None:
                position = voice._cursor - voice._stretcher.buffered / SAMPLE_RATE
                entry = (heard_at + count / SAMPLE_RATE, position, not voice._is_silent, level_dbfs(samples))
                self.heard.append(entry)
        return samples


class WatchedSound:
    """The sound of a call on a loudspeaker, and its log."""

    def __init__(self, streams: Mapping[int, VoiceStream], speaker: str) -> None:
        """Open the loudspeaker. speaker : as for open_speaker, empty for the default. Raises AudioError."""
        self.mixer = WatchedMixer(streams)
        self._clock = CallbackClock()
        self._speaker: Speaker = open_speaker(speaker or None, clock=self._clock)
        self.output = LoudspeakerSound(self.mixer, self._speaker)
        self._openings: list[tuple[float, float]] = []

    def on_frames_drawn(self, frames: Iterable[MotionFrame | None], at: float) -> None:
        """Log the lip opening of the first participant, FAPU units."""
        for frame in list(frames)[:1]:
            if frame is not None:
                opening = frame.displacements[UPPER_LIP, 1] - frame.displacements[LOWER_LIP, 1]
                self._openings.append((at, round(float(opening), 2)))

    def figures(self) -> dict[str, Any]:
        """Return what to log, and begin anew.

        concealed_ms : of the last second; underruns, missing_ms : since the start; heard, openings : since the last log
        """
        with self.output.lock:
            heard, self.mixer.heard = self.mixer.heard, []
            concealed = sum(voice.concealed_s for voice in self.mixer.participants.values())
        openings, self._openings = self._openings, []
        longest, self._clock.longest_s = self._clock.longest_s, 0.0
        return {
            "underruns": self._speaker.underruns,
            "missing_ms": 1000 * self._speaker._buffer.missing / DEVICE_RATE,
            "callback_gap_ms": 1000 * longest,
            "output_ms": 1000 * self._speaker.latency_s,
            "concealed_ms": 1000 * concealed,
            "heard": heard,
            "openings": openings,
            "sound_fault": self.output.fault,
        }
