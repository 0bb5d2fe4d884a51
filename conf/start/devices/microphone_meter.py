"""The level of the microphone that is chosen."""

from __future__ import annotations

import time
from collections.abc import Callable

from conf.audio.devices import Microphone, open_microphone
from conf.start.devices.device_thread import DeviceThread
from conf.start.devices.level_meter import LevelMeter

PERIOD_S = 0.03


class MicrophoneMeter:
    """An open microphone and its level."""

    def __init__(self, name: str | None, *, opener: Callable[[str | None], Microphone] = open_microphone) -> None:
        """Open a microphone in a thread. name : as the option takes it, None for the system's default"""
        self._name = name
        self._opener = opener
        self._meter = LevelMeter()
        self._device = DeviceThread(self._use, name="microphone meter")

    @property
    def error(self) -> str:
        """Return why there is no level, "" if there is one or the microphone is being opened."""
        return self._device.error

    @property
    def level(self) -> float:
        """Return the level from 0 to 1."""
        return self._meter.level

    def begin_close(self) -> None:
        """Tell the thread to release the microphone, without waiting."""
        self._device.begin_close()

    def close(self) -> bool:
        """Release the microphone. Returns False if its driver does not let go of it."""
        return self._device.close()

    def _use(self, thread: DeviceThread) -> None:
        self._meter = LevelMeter()
        with self._opener(self._name) as microphone:
            while not thread.wait(PERIOD_S):
                block = microphone.read()
                if block is not None:
                    self._meter.update(block.samples, time.monotonic())
                    thread.error = ""
