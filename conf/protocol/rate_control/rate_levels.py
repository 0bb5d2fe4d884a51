"""The rate levels: what to send at which rate, the highest first. Tables only.

Without voice a level is a motion profile. With voice it is a voice format too, and the cadence of both: a datagram
carries a voice packet and the motion of its time. On a lossy link a level with little voice in long datagrams repeats
each packet in the next one, at a lower bit rate, so that it costs the same.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

from conf.protocol.voice.formats import VoiceFormat


class VoiceMode(StrEnum):
    """The user's choice of the voice codec."""

    AUTOMATIC = "auto"
    OPUS = "opus"
    CODEC2 = "codec2"
    OFF = "off"


@dataclass(frozen=True)
class RateLevel:
    """A motion profile and how many times its usual number of frames share a datagram, and the voice beside it.

    kbps : rate that the level needs, headers and reports included
    voice : None for motion alone
    lossy_voice : used instead from a loss of `lossy_from` on, 0 to 1; None for no other
    """

    profile: str
    kbps: float
    bundling: int = 1
    voice: VoiceFormat | None = None
    lossy_voice: VoiceFormat | None = None
    lossy_from: float = 1.0


def _opus(bit_rate: int, frame_ms: int, frames: int, *, repeated: int = 0) -> VoiceFormat:
    return VoiceFormat("opus", bit_rate, frame_ms, frames, fixed_size=False, repeated=repeated)


def _codec2(bit_rate: int, frame_ms: int, frames: int, *, repeated: int = 0) -> VoiceFormat:
    return VoiceFormat("codec2", bit_rate, frame_ms, frames, fixed_size=True, repeated=repeated)


RATE_LEVELS = (RateLevel("rich", 11.0), RateLevel("live", 5.8), RateLevel("live", 4.0, 2), RateLevel("narrow", 2.4))

# Measured as STOI at random loss (tools/bench/voice.py). At 16 kbit/s repetition pays for itself in longer packets,
# which save half of the headers; 9.6 has no room for Opus twice. Two packets of Codec2 1200 do not fit 2.4 kbit/s, and
# one of them is worth more than two of Codec2 700C. A loss of 10 % must be found from a few dozen datagrams: the
# thresholds are low.
VOICE_LEVELS = (
    RateLevel("voice", 16.0, 1, _opus(9000, 60, 1), _opus(6000, 60, 2, repeated=2), 0.04),
    RateLevel("voice", 9.6, 2, _opus(6000, 60, 2), _codec2(3200, 20, 12, repeated=12), 0.05),
    RateLevel("narrow", 6.0, 1, _codec2(3200, 20, 10), _codec2(1600, 40, 5, repeated=5), 0.03),
    RateLevel("slow", 4.8, 1, _codec2(2400, 20, 12), _codec2(1200, 40, 6, repeated=6), 0.03),
    RateLevel("slow", 2.4, 2, _codec2(1200, 40, 12)),
)


def levels_for(mode: VoiceMode, /) -> tuple[RateLevel, ...]:
    """Return the levels of a choice of the voice codec."""
    if mode is VoiceMode.OFF:
        return RATE_LEVELS
    return tuple(level for level in map(_restricted(mode), VOICE_LEVELS) if level.voice)


def _restricted(mode: VoiceMode) -> Callable[[RateLevel], RateLevel]:
    """Return a function that removes the formats of other codecs from a level."""

    def allowed(voice_format: VoiceFormat | None) -> VoiceFormat | None:
        is_allowed = voice_format and mode in (VoiceMode.AUTOMATIC, voice_format.codec)
        return voice_format if is_allowed else None

    return lambda level: replace(level, voice=allowed(level.voice), lossy_voice=allowed(level.lossy_voice))
