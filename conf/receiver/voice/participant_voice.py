"""One participant's voice as continuous sound, each sample at its playout time.

Strategy. The playout clock says which stream time is due; the cursor says up to where the voice has been decoded. Sound
is taken as it is needed: a received frame is decoded, a lost one concealed, silence filled with noise of the level that
the sender has told. When the clock and the sound disagree, because the playout delay has changed or the loudspeaker's
rate is not exactly the microphone's, the sound is stretched or shrunk by up to a tenth; a large difference is jumped,
in silence any.
"""

from collections import deque
from collections.abc import Callable
from typing import Protocol

import numpy as np

from conf.audio.codecs.interface import VoiceDecoder
from conf.audio.codecs.registry import create_decoder
from conf.audio.comfort_noise import ComfortNoise
from conf.audio.samples import SAMPLE_RATE, SILENCE_DBFS, Samples, level_dbfs
from conf.audio.stretching import TimeStretcher
from conf.errors import AudioError
from conf.protocol.stream_clocks import MAX_STRETCH
from conf.protocol.voice.formats import VoiceFormat, VoiceFrame

TOLERANCE_S = 0.005  # between clock and sound; below it nothing is stretched
CORRECTION_S = 0.4  # a difference is made good in about so long
MAX_STRETCHED_S = 0.25  # a larger difference is jumped
MAX_MISFIT_S = 0.005  # between the end of a frame and the start of the next, which then follow without a gap
CONCEALMENT_WINDOW_S = 1.0
BLOCK_S = 0.01  # what is rendered at a time
MAX_LOOKAHEAD_S = 0.025  # the margin of the playout clock has room for the rest
MAX_NEW_FRAMES = 64  # decoded in one step: bounds the time whatever a peer sends


class VoiceSource(Protocol):
    """The incoming voice of one participant, as conf.protocol.voice.inbound gives it."""

    noise_level: int

    def frames_until(self, stream_time: float, /) -> list[VoiceFrame]: ...
    def awaits_packet(self, stream_time: float, /) -> bool: ...


class ParticipantVoice:
    """Turns one participant's frames into sound.

    level_dbfs : of the newest sound; late_s : of the same, against the playhead, negative if it is early
    concealed_s : duration concealed within the last CONCEALMENT_WINDOW_S
    unknown_codec : why the newest format cannot be decoded, empty if it can
    """

    def __init__(
        self,
        source: VoiceSource,
        rng: np.random.Generator,
        *,
        decoders: Callable[[str, int, int], VoiceDecoder] = create_decoder,
    ) -> None:
        """rng : of the comfort noise"""
        self.level_dbfs = SILENCE_DBFS
        self.late_s = 0.0
        self.unknown_codec = ""
        self._source = source
        self._decoders = decoders
        self._format: VoiceFormat | None = None
        self._decoder: VoiceDecoder | None = None
        self._noise = ComfortNoise(rng)
        self._stretcher = TimeStretcher()
        self._decoded = np.zeros(0, np.int16)  # not yet taken
        self._cursor: float | None = None  # stream time of the first sample in _decoded
        self._pending: deque[VoiceFrame] = deque()  # received, later than the cursor
        self._is_silent = True
        self._concealed: deque[tuple[float, float]] = deque()  # stream time, duration

    @property
    def lookahead_s(self) -> float:
        """By how much the decoder may be ahead of what is heard: by a block and the codec's delay."""
        return min(BLOCK_S + self._delay_s, MAX_LOOKAHEAD_S)

    @property
    def concealed_s(self) -> float:
        """Duration of the sound that was concealed in the last second."""
        return sum(duration for _, duration in self._concealed)

    def awaits_packet(self, playhead: float, count: int) -> bool:
        """Return whether `render` would begin to conceal what may only be late."""
        if self._cursor is None or self._is_silent:
            return False
        missing_s = self._stretcher.missing(count, _speed(self._error(playhead))) / SAMPLE_RATE
        return self._source.awaits_packet(self._cursor + missing_s + self._delay_s)

    def render(self, playhead: float, count: int) -> Samples:
        """Return the next `count` samples. playhead : stream time at which the first of them will be heard"""
        if self._cursor is None:
            self._cursor = playhead
        error = self._error(playhead)
        if abs(error) > MAX_STRETCHED_S or (self._is_silent and abs(error) > TOLERANCE_S):
            self._jump(error)
            error = 0.0
        self.late_s = error
        speed = _speed(error)
        if missing := self._stretcher.missing(count, speed):
            self._stretcher.push(self._next(missing))
        return self._stretcher.pull(count, speed)

    def _error(self, playhead: float) -> float:
        """Return by how many seconds the sound is later than the playhead."""
        assert self._cursor is not None
        return playhead - (self._cursor - self._stretcher.buffered / SAMPLE_RATE)

    def _jump(self, error: float) -> None:
        """Move the cursor by `error` seconds, in sound that has been decoded or in silence."""
        assert self._cursor is not None
        self._cursor += error
        skipped = round(error * SAMPLE_RATE)
        if skipped > 0:
            self._decoded = self._decoded[skipped:]
        elif len(self._decoded):
            self._decoded = np.concatenate([self._noise.generate(-skipped, -self._source.noise_level), self._decoded])

    def _next(self, count: int) -> Samples:
        """Return the next `count` samples of the participant's sound and move the cursor."""
        assert self._cursor is not None
        end = self._cursor + count / SAMPLE_RATE
        has_voice = len(self._decoded) > 0
        while len(self._decoded) < count:
            decoded_end = self._cursor + len(self._decoded) / SAMPLE_RATE
            latest = max(end, decoded_end + MAX_MISFIT_S) if has_voice else end  # start of a frame that follows
            if not self._pending:
                self._pending.extend(self._source.frames_until(latest + self._delay_s)[:MAX_NEW_FRAMES])
            if not self._pending or (start := self._pending[0].timestamp - self._delay_s) > latest:
                break
            has_voice = True
            samples = self._decode(self._pending.popleft())
            if start - decoded_end > MAX_MISFIT_S:
                silence = self._silence(round((start - decoded_end) * SAMPLE_RATE))
                self._decoded = np.concatenate([self._decoded, silence])
            elif decoded_end - start > MAX_MISFIT_S:
                samples = samples[round((decoded_end - start) * SAMPLE_RATE) :]
            self._decoded = np.concatenate([self._decoded, samples])
        if len(self._decoded) < count:
            self._decoded = np.concatenate([self._decoded, self._silence(count - len(self._decoded))])
        taken, self._decoded = self._decoded[:count], self._decoded[count:]
        self._cursor = end
        self._is_silent = not has_voice
        self.level_dbfs = level_dbfs(taken)
        while self._concealed and self._concealed[0][0] < self._cursor - CONCEALMENT_WINDOW_S:
            self._concealed.popleft()
        return taken

    @property
    def _delay_s(self) -> float:
        return self._decoder.delay_s if self._decoder else 0.0

    def _silence(self, count: int) -> Samples:
        return self._noise.generate(count, -self._source.noise_level)

    def _decode(self, frame: VoiceFrame) -> Samples:
        if frame.format != self._format:
            self._format = frame.format
            try:
                self._decoder, self.unknown_codec = self._decoders(*_settings(frame.format)), ""
            except AudioError as error:
                self._decoder, self.unknown_codec = None, str(error)
        if self._decoder is None:
            return self._silence(SAMPLE_RATE * frame.format.frame_ms // 1000)
        if frame.data is None:
            self._concealed.append((frame.timestamp, frame.format.frame_ms / 1000))
            return self._decoder.conceal()
        return self._decoder.decode(frame.data)


def _speed(error: float) -> float:
    """Return the speed at which sound that is so many seconds late is played."""
    if abs(error) < TOLERANCE_S:
        return 1.0
    return 1.0 + float(np.clip(error / CORRECTION_S, -MAX_STRETCH, MAX_STRETCH))


def _settings(voice_format: VoiceFormat) -> tuple[str, int, int]:
    return voice_format.codec, voice_format.bit_rate, voice_format.frame_ms
