"""What is Opus's own: its formats, its rate, its concealment of damaged frames."""

import numpy as np
import pytest

from conf.audio.codecs.opus import OpusDecoder, OpusEncoder
from conf.audio.samples import level_dbfs
from conf.errors import AudioError
from tests.support.synthetic_voice import speech, vowel


def test_formats_that_are_not_used_are_named() -> None:
    with pytest.raises(AudioError, match="Opus has frames of 10, 20, 40, 60 ms, not of 120"):
        OpusEncoder(6000, 120)
    with pytest.raises(AudioError, match="Opus is used from 4000 to 64000 bit/s here, not at 100"):
        OpusEncoder(100, 60)
    with pytest.raises(AudioError, match="not of 15"):
        OpusDecoder(15)


def test_a_higher_rate_makes_longer_frames() -> None:
    sound = speech(1.2).reshape(-1, 960)
    sizes = [
        sum(len(encoder.encode(frame)) for frame in sound)
        for encoder in (OpusEncoder(6000, 60), OpusEncoder(12000, 60))
    ]
    assert sizes[1] > 1.5 * sizes[0]


def test_a_frame_of_another_duration_is_concealed() -> None:
    encoder, decoder = OpusEncoder(9000, 20), OpusDecoder(60)
    data = [encoder.encode(frame) for frame in vowel(0, 0.2).reshape(-1, 320)][-1]
    assert not decoder.decode(data).any()
    assert decoder.decode(data).shape == (960,)


def test_a_long_loss_fades_to_silence() -> None:
    encoder, decoder = OpusEncoder(9000, 60), OpusDecoder(60)
    for frame in vowel(0, 0.6).reshape(-1, 960):
        decoder.decode(encoder.encode(frame))
    levels = [level_dbfs(decoder.conceal()) for _ in range(12)]
    assert levels[-1] < -60 and levels[0] > -40


def test_a_strided_frame_is_encoded_as_its_copy() -> None:
    wide = np.stack([vowel(1, 0.06), np.zeros(960, np.int16)], axis=1)
    assert OpusEncoder(6000, 60).encode(wide[:, 0]) == OpusEncoder(6000, 60).encode(wide[:, 0].copy())
