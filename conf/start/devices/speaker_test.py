"""A test tone through the speaker that is chosen, and its level."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from conf.audio.devices import Speaker, open_speaker
from conf.audio.samples import SAMPLE_RATE, Samples
from conf.start.devices.device_thread import DeviceThread
from conf.start.devices.level_meter import LevelMeter

NOTES_HZ = (523.25, 659.25, 783.99)  # C, E, G
NOTE_S = 0.35
FADE_S = 0.02  # without it a note begins with a click
AMPLITUDE = 8000.0  # -12 dBFS: heard, and not too loud in headphones
PERIOD_S = 0.03


class SpeakerTest:
    """A tone that is being played, once."""

    def __init__(self, name: str | None, *, opener: Callable[[str | None], Speaker] = open_speaker) -> None:
        """Play in a thread. name : as the option takes it, None for the system's default"""
        self._name = name
        self._opener = opener
        self._meter = LevelMeter()
        self._device = DeviceThread(self._use, name="speaker test", retry=False)

    @property
    def error(self) -> str:
        """Return why nothing is heard, "" if the tone is played."""
        return self._device.error

    @property
    def is_playing(self) -> bool:
        """Return whether the tone has not ended."""
        return self._device.is_running

    @property
    def level(self) -> float:
        """Return the level of what the speaker plays, from 0 to 1."""
        return self._meter.level if self.is_playing else 0.0

    def begin_close(self) -> None:
        """Tell the thread to release the speaker, without waiting."""
        self._device.begin_close()

    def close(self) -> bool:
        """Stop and release the speaker. Returns False if its driver does not let go of it."""
        return self._device.close()

    def _use(self, thread: DeviceThread) -> None:
        with self._opener(self._name) as speaker:
            speaker.write(make_test_tone())
            end: float | None = None  # known when the device has asked for the last sample: it may start late
            while (end is None or time.monotonic() < end) and not thread.wait(PERIOD_S):
                speaker.check()
                if (played := speaker.read_played()) is not None:
                    self._meter.update(played.samples, time.monotonic())
                if end is None and not speaker.queued_s:
                    end = time.monotonic() + speaker.device_latency_s


def make_test_tone() -> Samples:
    """Return the notes, one after another, (n,) int16 at SAMPLE_RATE."""
    times = np.arange(round(NOTE_S * SAMPLE_RATE)) / SAMPLE_RATE
    fade = np.clip(np.minimum(times, NOTE_S - times) / FADE_S, 0, 1)
    notes = [fade * np.sin(2 * np.pi * frequency * times) for frequency in NOTES_HZ]
    return np.asarray(AMPLITUDE * np.concatenate(notes), np.int16)
