"""The microphone as a sound source: captured blocks on the clock of the frames."""

import time
from collections.abc import Callable
from dataclasses import replace

from conf.audio.devices import open_microphone
from conf.audio.samples import AudioBlock


class MicrophoneSource:
    """An open microphone."""

    @property
    def offset_s(self) -> float:
        """The clock of the frames minus that of the sound device, as far as known."""
        return self._offset or 0.0

    def __init__(
        self, device: str | None = None, *, live_frames: bool = True, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Open it.

        device : number or name as `conf devices` lists them, None for the default
        live_frames : the frames beside it are a camera's, stamped on `clock`. Those of a clip have times of their own,
            to which the times of the sound are converted
        Raises AudioError.
        """
        self._device = open_microphone(device, clock=clock)
        self._clock = clock
        self._offset: float | None = 0.0 if live_frames else None  # clock of the frames minus `clock`

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return what was captured since the last call; `until` is now. Raises AudioError if the device is gone."""
        if self._offset is None:
            self._offset = until - self._clock()
        block = self._device.read()
        return [] if block is None else [replace(block, timestamp=block.timestamp + self._offset)]

    def close(self) -> None:
        """Stop and release it."""
        self._device.close()
