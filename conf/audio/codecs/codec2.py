"""Codec2 from 700 to 3200 bit/s: fixed-size frames, 8 kHz inside, resampled here to and from 16 kHz.

The library has no concealment: a lost frame is the last one decoded again, faded after a moment, and the first good
frame after a loss fades in. Its synthesis overlaps frames, so that repeating leaves no click.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.audio.resampling import Resampler
from conf.audio.samples import SAMPLE_RATE, Samples, to_int16
from conf.errors import AudioError

FRAME_MS = {3200: 20, 2400: 20, 1600: 40, 1400: 40, 1300: 40, 1200: 40, 700: 40}  # by bit rate; 700 is mode 700C
_RATE = 8000  # of the library, samples a second
_SILENT_S = 0.16  # after the last good frame; .005 STOI better at 10 % of loss than half of it, .018 at 20 %
# Modes that predict pitch and energy: each repetition takes their predictor further away.
_PREDICTIVE, _MAX_REPETITIONS = (2400, 1400, 1200), 3
_HOLD = 0.25  # of that time, before the sound begins to fade
_FADE_IN_S = 0.01
_LIBRARY_DELAY_S = {700: 0.032}  # by bit rate; where the intelligibility (STOI) of a round trip is highest
_OTHER_DELAY_S = 0.020
MISSING = "Codec2 is missing, so voice needs a link of 9.6 kbit/s or more: type  pip install pycodec2."


class Codec2Encoder:
    """Codec2 for one talker."""

    sample_rate = SAMPLE_RATE

    def __init__(self, bit_rate: int, frame_ms: int) -> None:
        """Raise AudioError if the library is missing or has no such format."""
        self._codec = _open(bit_rate, frame_ms)
        self._resampler = Resampler(SAMPLE_RATE, _RATE)
        self.frame_samples = SAMPLE_RATE * frame_ms // 1000

    def encode(self, frame: Samples, /) -> bytes:
        """Return the bits of one frame, (frame_samples,) int16, left-aligned."""
        if frame.shape != (self.frame_samples,):
            raise ValueError(f"frame must have {self.frame_samples} samples")
        return bytes(self._codec.encode(self._resampler.process(frame)))


class Codec2Decoder:
    """Codec2 of one talker."""

    sample_rate = SAMPLE_RATE

    def __init__(self, bit_rate: int, frame_ms: int) -> None:
        """Raise AudioError if the library is missing or has no such format."""
        self._codec = _open(bit_rate, frame_ms)
        self._resampler = Resampler(_RATE, SAMPLE_RATE)
        self.frame_samples = SAMPLE_RATE * frame_ms // 1000
        library = _LIBRARY_DELAY_S.get(bit_rate, _OTHER_DELAY_S)
        self.delay_s = library + self._resampler.delay_s + Resampler(SAMPLE_RATE, _RATE).delay_s
        self._frame_bytes = self._codec.bytes_per_frame()
        self._last = b""  # the last good frame
        self._lost_s = 0.0  # duration of the frames lost in a row
        self._silent_s = _MAX_REPETITIONS * frame_ms / 1000 if bit_rate in _PREDICTIVE else _SILENT_S

    def decode(self, data: bytes, /) -> Samples:
        """Return one frame, (frame_samples,) int16; data of another length is concealed."""
        if len(data) != self._frame_bytes:
            return self.conceal()
        decoded = self._codec.decode(data)
        if self._lost_s:
            gains = np.ones(len(decoded))
            count = round(_FADE_IN_S * _RATE)
            gains[:count] = np.linspace(float(self._gain(np.array(self._lost_s))), 1.0, count)
            decoded = to_int16(decoded * gains)
        self._last, self._lost_s = data, 0.0
        return self._resampler.process(decoded)

    def conceal(self) -> Samples:
        """Return the last frame again, in the end quieter; silence after a while and before the first good frame."""
        if not self._last:
            return np.zeros(self.frame_samples, np.int16)
        count = self.frame_samples * _RATE // SAMPLE_RATE
        times = self._lost_s + np.arange(1, count + 1) / _RATE
        self._lost_s = float(times[-1])
        gains = self._gain(times)
        if not gains.any():
            return self._resampler.process(np.zeros(count, np.int16))
        return self._resampler.process(to_int16(self._codec.decode(self._last) * gains))

    def _gain(self, lost_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gain of concealed sound at times after the last good frame, seconds."""
        return np.clip((self._silent_s - lost_s) / ((1 - _HOLD) * self._silent_s), 0.0, 1.0)


def _open(bit_rate: int, frame_ms: int) -> Any:
    """Return pycodec2's object of a mode."""
    if FRAME_MS.get(bit_rate) != frame_ms:
        modes = ", ".join(f"{rate} bit/s in frames of {duration} ms" for rate, duration in FRAME_MS.items())
        raise AudioError(f"Codec2 has no mode of {bit_rate} bit/s in frames of {frame_ms} ms, only {modes}.")
    try:
        from pycodec2.pycodec2 import Codec2
    except ImportError as error:
        raise AudioError(MISSING) from error
    return Codec2(bit_rate)
