"""Opus (RFC 6716) from about 5 kbit/s up, with the codec's own concealment.

Settings are those that were measured best for speech at 5 to 12 kbit/s: VoIP, voice, variable bit rate. At a constant
bit rate below 6000 libopus leaves SILK for CELT, which is unusable there; in-band FEC does not exist below 20 kbit/s.
"""

import ctypes
import weakref

import numpy as np

from conf.audio.codecs.interface import MAX_FRAME_BYTES
from conf.audio.codecs.opus_library import load_opus
from conf.audio.samples import SAMPLE_RATE, Samples
from conf.errors import AudioError

FRAME_MS = (10, 20, 40, 60)  # the durations of SILK
_MIN_RATE, _MAX_RATE = 4000, 64000
_VOIP = 2048
_SETTINGS = {4006: 1, 4024: 3001, 4010: 10}  # variable bit rate, voice, highest complexity: 8 to 14 ms of CPU a second
_SET_BIT_RATE = 4002
_DELAY_S = 0.0065  # look-ahead of SILK at 16 kHz: OPUS_GET_LOOKAHEAD says 104 samples


class OpusEncoder:
    """Opus for one talker, at a mean bit rate that it holds over a second."""

    sample_rate = SAMPLE_RATE

    def __init__(self, bit_rate: int, frame_ms: int) -> None:
        """Raise AudioError if libopus is missing or has no such format."""
        _check(frame_ms)
        if not _MIN_RATE <= bit_rate <= _MAX_RATE:
            raise AudioError(f"Opus is used from {_MIN_RATE} to {_MAX_RATE} bit/s here, not at {bit_rate}.")
        self.frame_samples = SAMPLE_RATE * frame_ms // 1000
        self._library = load_opus()
        self._state = self._library.opus_encoder_create(SAMPLE_RATE, 1, _VOIP, None)
        if not self._state:
            raise MemoryError
        weakref.finalize(self, self._library.opus_encoder_destroy, self._state)
        self._buffer = ctypes.create_string_buffer(MAX_FRAME_BYTES)
        for request, value in {**_SETTINGS, _SET_BIT_RATE: bit_rate}.items():
            self._library.opus_encoder_ctl(self._state, request, ctypes.c_int(value))

    def encode(self, frame: Samples, /) -> bytes:
        """Return the code of one frame, (frame_samples,) int16."""
        if frame.shape != (self.frame_samples,):
            raise ValueError(f"frame must have {self.frame_samples} samples")
        samples = np.ascontiguousarray(frame, dtype=np.int16)
        length: int = self._library.opus_encode(
            self._state, samples.ctypes.data, self.frame_samples, self._buffer, MAX_FRAME_BYTES
        )
        if length < 0:
            raise RuntimeError(f"opus_encode returned {length}")
        return self._buffer.raw[:length]


class OpusDecoder:
    """Opus of one talker; libopus finds rate and bandwidth in each frame."""

    sample_rate = SAMPLE_RATE
    delay_s = _DELAY_S

    def __init__(self, frame_ms: int) -> None:
        """Raise AudioError if libopus is missing or has no such format."""
        _check(frame_ms)
        self.frame_samples = SAMPLE_RATE * frame_ms // 1000
        self._library = load_opus()
        self._state = self._library.opus_decoder_create(SAMPLE_RATE, 1, None)
        if not self._state:
            raise MemoryError
        weakref.finalize(self, self._library.opus_decoder_destroy, self._state)

    def decode(self, data: bytes, /) -> Samples:
        """Return one frame, (frame_samples,) int16; data of another duration or damaged data is concealed."""
        samples: int = self._library.opus_packet_get_nb_samples(data, len(data), SAMPLE_RATE)
        if not data or samples != self.frame_samples:
            return self.conceal()
        frame = np.zeros(self.frame_samples, np.int16)
        if self._decode(data, frame) != self.frame_samples:
            return self.conceal()
        return frame

    def conceal(self) -> Samples:
        """Return one frame of libopus's own concealment, which fades to silence within about 200 ms."""
        frame = np.zeros(self.frame_samples, np.int16)
        self._decode(None, frame)
        return frame

    def _decode(self, data: bytes | None, frame: Samples) -> int:
        size = len(data) if data else 0
        return int(self._library.opus_decode(self._state, data, size, frame.ctypes.data, len(frame), 0))


def _check(frame_ms: int) -> None:
    if frame_ms not in FRAME_MS:
        raise AudioError(f"Opus has frames of {', '.join(map(str, FRAME_MS))} ms, not of {frame_ms}.")
