"""The rate levels: what to send at which rate, the highest first. Tables only.

Without voice a level is a motion profile. With voice it is a voice format too, and the cadence of both: a datagram
carries a voice packet and the motion of its time. On a lossy link the newest frames of each packet, or all, come again
in the next one, at a lower bit rate, so that it costs the same.
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
class LossyVoice:
    """The voice format of a level from a loss on.

    loss : of datagrams, 0 to 1; in_bursts : whether it is also better when three in a row are lost
    """

    loss: float
    voice: VoiceFormat
    in_bursts: bool = False


@dataclass(frozen=True)
class RateLevel:
    """A motion profile and how many times its usual number of frames share a datagram, and the voice beside it.

    kbps : rate that the level needs, headers and reports included
    voice : None for motion alone
    lossy : used instead when packets are lost, by rising loss
    """

    profile: str
    kbps: float
    bundling: int = 1
    voice: VoiceFormat | None = None
    lossy: tuple[LossyVoice, ...] = ()


def _opus(bit_rate: int, frame_ms: int, frames: int, *, repeated: int = 0) -> VoiceFormat:
    return VoiceFormat("opus", bit_rate, frame_ms, frames, fixed_size=False, repeated=repeated)


def _codec2(bit_rate: int, frame_ms: int, frames: int, *, repeated: int = 0) -> VoiceFormat:
    return VoiceFormat("codec2", bit_rate, frame_ms, frames, fixed_size=True, repeated=repeated)


RATE_LEVELS = (RateLevel("rich", 11.0), RateLevel("live", 5.8), RateLevel("live", 4.0, 2), RateLevel("narrow", 2.4))

# Measured as STOI at random loss (tools/bench/voice.py): each row begins where it becomes better than the one before.
# From 9.6 kbit/s up only so much is repeated at first that voice waits 40
# to 60 ms for it. At 6 and 4.8, part of a packet of Codec2 1600 is at no loss better than both no repetition and the
# whole. 9.6 kbit/s have no room for Opus twice. Codec2 1600 and 3200 predict nothing from frames that may be lost; 1200
# and 2400 do, and lose more. Two packets of Codec2 1200 do not fit 2.4 kbit/s. To begin a call with repetition costs
# clean links .03 to .07 for the first seconds and gives others .01.
VOICE_LEVELS = (
    RateLevel(
        "voice",
        16.0,
        1,
        _opus(9000, 60, 1),
        (
            LossyVoice(0.04, _opus(7000, 40, 2, repeated=1), in_bursts=True),
            LossyVoice(0.16, _opus(6000, 60, 2, repeated=2)),
        ),
    ),
    RateLevel(
        "voice",
        9.6,
        2,
        _opus(6000, 60, 2),
        (LossyVoice(0.04, _codec2(3200, 20, 6, repeated=3)), LossyVoice(0.16, _codec2(3200, 20, 9, repeated=9))),
    ),
    RateLevel("narrow", 6.0, 1, _codec2(3200, 20, 10), (LossyVoice(0.05, _codec2(1600, 40, 5, repeated=5)),)),
    RateLevel("slow", 4.8, 1, _codec2(2400, 20, 12), (LossyVoice(0.04, _codec2(1200, 40, 6, repeated=6)),)),
    RateLevel("slow", 2.4, 2, _codec2(1200, 40, 12)),
)


def levels_for(mode: VoiceMode, /) -> tuple[RateLevel, ...]:
    """Return the levels of a choice of the voice codec."""
    if mode is VoiceMode.OFF:
        return RATE_LEVELS
    return tuple(level for level in map(_restricted(mode), VOICE_LEVELS) if level.voice)


def _restricted(mode: VoiceMode) -> Callable[[RateLevel], RateLevel]:
    """Return a function that removes the formats of other codecs from a level."""

    def is_allowed(voice_format: VoiceFormat | None) -> bool:
        return voice_format is not None and mode in (VoiceMode.AUTOMATIC, voice_format.codec)

    def restricted(level: RateLevel) -> RateLevel:
        lossy = tuple(lossy for lossy in level.lossy if is_allowed(lossy.voice))
        return replace(level, voice=level.voice if is_allowed(level.voice) else None, lossy=lossy)

    return restricted
