"""The rate levels fit their rates by the sizes of WIRE.md."""

import pytest

from conf.protocol.codec.profiles import PROFILES
from conf.protocol.rate_control.rate_levels import RATE_LEVELS, VOICE_LEVELS, RateLevel, VoiceMode, levels_for
from conf.protocol.voice.formats import VoiceFormat

HEADERS, SEAL = 28, 14
VBR = {9000: 0.88, 7000: 0.86, 6000: 0.82}  # rate of Opus at 60 ms over its nominal one, measured on speech
# Bytes of a frame of motion, measured over the tracks held out of the training: tools/bench/codec.py.
FRAME_BYTES = {"voice": 5.0, "narrow": 4.1, "slow": 3.2}
REPORT_BYTES = 13


def cost(level: RateLevel, voice: VoiceFormat) -> float:
    """Return the usual kbit/s of voice, motion and reports, everything counted."""
    profile = PROFILES[level.profile]
    frames = voice.packet_s * profile.fps
    data = voice.nominal_bytes * (1.0 if voice.fixed_size else VBR[voice.bit_rate])
    reports = REPORT_BYTES * voice.packet_s / max(0.5, 4 * voice.packet_s)
    datagram = HEADERS + SEAL + 2 + data + 1 + 1 + frames * FRAME_BYTES[level.profile] + reports
    return datagram * 8 / voice.packet_s / 1000


@pytest.mark.parametrize("level", VOICE_LEVELS, ids=lambda level: str(level.kbps))
def test_a_level_fits_its_rate_and_repeating_costs_no_more(level: RateLevel) -> None:
    assert level.voice is not None
    assert 0.9 * level.kbps < cost(level, level.voice) <= level.kbps
    assert not level.voice.repeated
    assert [lossy.loss for lossy in level.lossy] == sorted(lossy.loss for lossy in level.lossy)
    for lossy in level.lossy:
        lossy.voice.check()
        assert lossy.voice.repeated and 0 < lossy.loss < 1
        assert cost(level, lossy.voice) <= level.kbps
    if level.lossy and level.kbps >= 9.6:
        waits_ms = level.lossy[0].voice.repeated * level.lossy[0].voice.frame_ms
        assert waits_ms <= 60, "so that voice is heard within 150 ms more than its datagram lasts"


@pytest.mark.parametrize("level", VOICE_LEVELS, ids=lambda level: str(level.kbps))
def test_the_cadence_of_motion_is_that_of_the_voice(level: RateLevel) -> None:
    assert level.voice is not None
    profile = PROFILES[level.profile]
    assert profile.frames_per_datagram * level.bundling / profile.fps == pytest.approx(level.voice.packet_s)
    assert profile.frames_per_datagram * level.bundling in profile.usual_counts
    assert profile.fps >= 12.5
    level.voice.check()


def test_levels_fall_and_modes_restrict_the_codec() -> None:
    assert levels_for(VoiceMode.OFF) == RATE_LEVELS and all(level.voice is None for level in RATE_LEVELS)
    assert levels_for(VoiceMode.AUTOMATIC) == VOICE_LEVELS
    all_levels: list[tuple[RateLevel, ...]] = [RATE_LEVELS, VOICE_LEVELS]
    for levels in all_levels:
        assert [level.kbps for level in levels] == sorted((level.kbps for level in levels), reverse=True)
    opus, codec2 = levels_for(VoiceMode.OPUS), levels_for(VoiceMode.CODEC2)
    assert [level.kbps for level in opus] == [16, 9.6] and [level.kbps for level in codec2] == [6, 4.8, 2.4]
    for levels, name in ((opus, "opus"), (codec2, "codec2")):
        formats = [f for level in levels for f in (level.voice, *(lossy.voice for lossy in level.lossy)) if f]
        assert {voice_format.codec for voice_format in formats} == {name}
    assert opus[1].lossy == ()
