"""From the microphone's sound to what a codec should get: no echo, rumble and noise, an even level, pauses marked.

The echo is removed first (echo_canceller.py). The other filters are WebRTC's (pywebrtc-audio). Two of their habits are
worked around. The gain control starts 15 dB up, which drives loud speech into its limiter for seconds (STOI .96 on
full-scale speech), so the sound enters 15 dB down and the gain starts at 1. The speech probability comes late, so
activity looks at the level, too.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.audio.echo_canceller import EchoCanceller
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE, AudioBlock, Samples, level_dbfs, power_dbfs, to_int16
from conf.audio.voice_activity import VoiceActivity

BLOCK_SAMPLES = SAMPLE_RATE // 100  # 10 ms, WebRTC's frame
MISSING = "pywebrtc-audio is missing, so noise and level stay as they are: type  pip install pywebrtc-audio."

# The gain control fills the scale. Codecs need headroom: Codec2's energies end 6 dB lower (STOI .01 better),
# and what a decoder overshoots was clipped. With it speech has -24 dBFS, near the -26 of ITU-T P.56.
_HEADROOM = 0.5
_INITIAL_GAIN = 10 ** (-15 / 20)  # of the sound that enters the gain control
_DELAY_S = 0.006  # of noise suppression, measured by correlation
_NOISE_WEIGHT = 0.05  # of a new block in the background's power: a time constant of 0.2 s
_GAP_S = 0.001  # time stamps further apart than this are of another stretch of sound


@dataclass(frozen=True)
class VoiceBlock:
    """10 ms of processed sound.

    timestamp : capture time of the first sample, s
    samples : (BLOCK_SAMPLES,) int16
    active : whether speech is noticed, in this block or within the hangover; it began LOOK_BACK blocks before
    """

    timestamp: float
    samples: Samples
    active: bool


class VoiceProcessor:
    """The processing of one microphone.

    fault : why sound passes unprocessed, one sentence for the user, or None
    noise_dbfs : level of the returned sound in pauses, dBFS, for comfort noise
    """

    def __init__(
        self,
        *,
        gain: bool = True,
        noise_suppression: bool = True,
        read_played: Callable[[], AudioBlock | None] | None = None,
    ) -> None:
        """Prepare the filters.

        read_played : returns what the loudspeaker has played since it was last called, to remove its echo: read_played
            of an open Speaker
        """
        self.fault: str | None = None
        self._filter: Any = None
        self._gain: Any = None
        try:
            import pywebrtc_audio
        except ImportError:
            self.fault = MISSING
        else:
            self._filter = pywebrtc_audio.AudioProcessor(
                SAMPLE_RATE, high_pass_filter=True, noise_suppression=noise_suppression
            )
            self._gain = pywebrtc_audio.GainController(SAMPLE_RATE) if gain else None
        self._delay_s = _DELAY_S if self._filter and noise_suppression else 0.0
        self._read_played = read_played
        self._echo_canceller = EchoCanceller() if read_played else None
        self._activity = VoiceActivity()
        self._rest = AudioBlock(0.0, np.zeros(0, np.int16))  # less than a block
        self._noise_power = 0.0

    @property
    def noise_dbfs(self) -> float:
        """Return the level of the background after processing, dBFS."""
        return power_dbfs(self._noise_power)

    def process(self, block: AudioBlock) -> list[VoiceBlock]:
        """Return the blocks that this sound completes, in order of time.

        block : of any length; a gap to the last one's end starts a new stretch, and what fills no block is dropped
        """
        if self._echo_canceller and self._read_played:
            block = self._echo_canceller.process(block, self._read_played())
        if len(self._rest.samples) and abs(block.timestamp - self._rest.end) > _GAP_S:
            self._rest = replace(self._rest, samples=self._rest.samples[:0])
        start = self._rest.timestamp if len(self._rest.samples) else block.timestamp
        samples = np.concatenate([self._rest.samples, block.samples])
        whole = len(samples) // BLOCK_SAMPLES * BLOCK_SAMPLES
        pieces = [
            (start + first / SAMPLE_RATE - self._delay_s, samples[first : first + BLOCK_SAMPLES])
            for first in range(0, whole, BLOCK_SAMPLES)
        ]
        self._rest = AudioBlock(start + whole / SAMPLE_RATE, samples[whole:])
        return [self._process_block(timestamp, piece) for timestamp, piece in pieces]

    def _process_block(self, timestamp: float, samples: Samples) -> VoiceBlock:
        if self._filter is None:
            level, probability = level_dbfs(samples), 0.0
        else:
            scaled = samples.astype(np.float32) * np.float32(_INITIAL_GAIN / FULL_SCALE)
            filtered = np.asarray(self._filter.process(scaled), np.float32)
            level = level_dbfs(_from_float(filtered))
            probability = float(self._filter.speech_probability)
            if self._gain is not None:
                samples = to_int16(np.asarray(self._gain.process(filtered), np.float64) * (_HEADROOM * FULL_SCALE))
                probability = float(self._gain.speech_probability)
            else:
                samples = _from_float(filtered)
        active = self._activity.update(level, probability)
        if not active:
            power = 10 ** (level_dbfs(samples) / 10)
            self._noise_power += _NOISE_WEIGHT * (power - self._noise_power)
        return VoiceBlock(timestamp, samples, active)


def _from_float(values: NDArray[np.float32]) -> Samples:
    return to_int16(values.astype(np.float64) * (FULL_SCALE / _INITIAL_GAIN))
