"""The microphone as a sound source: captured blocks on the clock of the frames."""

import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import replace

from conf.audio.devices import Microphone, open_microphone
from conf.audio.samples import AudioBlock
from conf.errors import AudioError

RETRY_S = 2.0  # between two attempts to open a microphone that is gone
# The first calls of `read` may come some 20 ms after the `until` that they are given: the first frame takes so long.
SETTLING_READS = 8


class MicrophoneSource:
    """An open microphone. One that is gone is opened again when it is back, in a thread, as that takes a while."""

    @property
    def offset_s(self) -> float:
        """The clock of the frames minus that of the sound device, as far as known."""
        return 0.0 if self._settling else self._offset

    def __init__(
        self, device: str | None = None, *, live_frames: bool = True, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Open it.

        device : number or name as `conf devices` lists them, None for the default
        live_frames : the frames beside it are a camera's, stamped on `clock`. Those of a clip have times of their own,
            to which the times of the sound are converted
        Raises AudioError.
        """
        self._name = device
        self._device: Microphone | None = open_microphone(device, clock=clock)
        self._fault = AudioError()
        self._tried_at = float("-inf")
        self._opening: threading.Thread | None = None
        self._clock = clock
        self._offset = 0.0 if live_frames else float("-inf")  # clock of the frames minus `clock`
        self._settling = 0 if live_frames else SETTLING_READS

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return what was captured since the last call; `until` is now.

        Raises AudioError while the device is gone.
        """
        if self._settling:
            self._settling -= 1
            self._offset = max(self._offset, until - self._clock())
            if self._settling:
                return []
        if self._device is None:
            self._try_again()
            raise self._fault
        try:
            block = self._device.read()
        except AudioError as error:
            self._fault, gone, self._device = error, self._device, None
            gone.close()
            raise
        return [] if block is None else [replace(block, timestamp=block.timestamp + self._offset)]

    def close(self) -> None:
        """Stop and release it."""
        if self._opening:
            self._opening.join()
        if self._device:
            self._device.close()

    def _try_again(self) -> None:
        """Begin to open the device, if it is time for it."""
        if self._clock() - self._tried_at >= RETRY_S and not (self._opening and self._opening.is_alive()):
            self._tried_at = self._clock()
            self._opening = threading.Thread(target=self._open, name="microphone", daemon=True)
            self._opening.start()

    def _open(self) -> None:
        with contextlib.suppress(AudioError):
            self._device = open_microphone(self._name, clock=self._clock)
