"""Every codec fulfils the interface, at every rate: durations, sizes, sound kept, concealment without clicks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.audio.codecs.interface import MAX_FRAME_BYTES
from conf.audio.codecs.registry import create_decoder, create_encoder
from conf.audio.samples import SAMPLE_RATE, Samples, level_dbfs
from tests.support.synthetic_voice import max_jump, pitch_hz, speech, vowel

FORMATS = [
    *(("opus", rate, 60) for rate in (5000, 6000, 9000, 16000)),
    *(("opus", 9000, duration) for duration in (10, 20, 40)),
    *(("codec2", rate, 20) for rate in (3200, 2400)),
    *(("codec2", rate, 40) for rate in (1600, 1400, 1300, 1200, 700)),
]
every_format = pytest.mark.parametrize(("codec", "bit_rate", "frame_ms"), FORMATS)


def encode_all(codec: str, bit_rate: int, frame_ms: int, sound: Samples) -> list[bytes]:
    encoder = create_encoder(codec, bit_rate, frame_ms)
    usable = len(sound) // encoder.frame_samples * encoder.frame_samples
    return [encoder.encode(frame) for frame in sound[:usable].reshape(-1, encoder.frame_samples)]


@every_format
def test_a_vowel_keeps_its_pitch_and_level(codec: str, bit_rate: int, frame_ms: int) -> None:
    sound = vowel(0, 0.72, pitch=120)
    frames = encode_all(codec, bit_rate, frame_ms, sound)
    decoder = create_decoder(codec, bit_rate, frame_ms)
    decoded = np.concatenate([decoder.decode(frame) for frame in frames])
    assert decoded.dtype == np.int16 and len(decoded) == len(frames) * decoder.frame_samples
    assert decoder.sample_rate == SAMPLE_RATE and decoder.frame_samples == SAMPLE_RATE * frame_ms // 1000
    steady = slice(SAMPLE_RATE // 4, None)
    assert pitch_hz(decoded[steady]) == pytest.approx(120, rel=0.03)
    assert level_dbfs(decoded[steady]) == pytest.approx(level_dbfs(sound[steady]), abs=4)


@pytest.mark.slow
@every_format
def test_the_decoded_sound_lags_by_the_stated_delay(codec: str, bit_rate: int, frame_ms: int) -> None:
    sound = speech(2.4, seed=3)
    frames = encode_all(codec, bit_rate, frame_ms, sound)
    decoder = create_decoder(codec, bit_rate, frame_ms)
    decoded = np.concatenate([decoder.decode(frame) for frame in frames])
    envelopes = [np.convolve(np.abs(x[: len(decoded)].astype(float)), np.hanning(320)) for x in (sound, decoded)]
    before, after = (envelope - envelope.mean() for envelope in envelopes)
    lags = range(0, 1120, 16)
    best = max(lags, key=lambda lag: float(before[: len(before) - lag] @ after[lag:]))
    assert best / SAMPLE_RATE == pytest.approx(decoder.delay_s, abs=0.012)


@every_format
def test_frames_have_the_size_that_the_format_promises(codec: str, bit_rate: int, frame_ms: int) -> None:
    frames = encode_all(codec, bit_rate, frame_ms, speech(1.2, seed=5))
    bits = bit_rate * frame_ms // 1000
    if codec == "codec2":
        assert {len(frame) for frame in frames} == {-(-bits // 8)}
        padding = -bits % 8
        assert all(frame[-1] & ((1 << padding) - 1) == 0 for frame in frames)
    else:
        assert max(map(len, frames)) <= MAX_FRAME_BYTES
        assert 8 * sum(map(len, frames)) < 1.1 * bits * len(frames) + 200


@every_format
def test_lost_frames_fade_without_clicks_and_sound_returns(codec: str, bit_rate: int, frame_ms: int) -> None:
    frames = encode_all(codec, bit_rate, frame_ms, vowel(3, 1.2, pitch=150))
    clean, lossy = (create_decoder(codec, bit_rate, frame_ms) for _ in range(2))
    whole = np.concatenate([clean.decode(frame) for frame in frames])
    first, last = 6, 6 + max(4, 480 // frame_ms // 2)
    parts = [lossy.conceal() if first <= i < last else lossy.decode(frame) for i, frame in enumerate(frames)]
    concealed = np.concatenate(parts)
    assert len(concealed) == len(whole)
    assert max_jump(concealed) < 1.6 * max_jump(whole)
    assert level_dbfs(parts[last - 1]) < level_dbfs(parts[first - 1]) - 6
    assert level_dbfs(parts[-1]) == pytest.approx(level_dbfs(whole[-len(parts[-1]) :]), abs=3)


@every_format
def test_concealing_before_the_first_frame_is_silence(codec: str, bit_rate: int, frame_ms: int) -> None:
    decoder = create_decoder(codec, bit_rate, frame_ms)
    silence = decoder.conceal()
    assert len(silence) == decoder.frame_samples and not silence.any()


@pytest.mark.slow
@given(data=st.lists(st.binary(max_size=300), min_size=1, max_size=6), form=st.sampled_from(FORMATS))
def test_any_bytes_decode_to_one_frame(data: list[bytes], form: tuple[str, int, int]) -> None:
    decoder = create_decoder(*form)
    for piece in data:
        frame = decoder.decode(piece)
        assert frame.shape == (decoder.frame_samples,) and frame.dtype == np.int16


@every_format
def test_a_frame_of_another_length_is_refused(codec: str, bit_rate: int, frame_ms: int) -> None:
    encoder = create_encoder(codec, bit_rate, frame_ms)
    with pytest.raises(ValueError, match=f"frame must have {encoder.frame_samples} samples"):
        encoder.encode(np.zeros(encoder.frame_samples - 1, np.int16))
