"""Change of rate: exact counts, no seams, the pass band kept, aliases removed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.audio.resampling import Resampler
from conf.audio.samples import Samples

RATES = [(48000, 16000), (16000, 48000), (16000, 8000), (8000, 16000), (44100, 16000), (16000, 16000)]


def sine(hertz: float, rate: int, seconds: float = 0.5) -> Samples:
    return np.rint(10000 * np.sin(2 * np.pi * hertz * np.arange(round(seconds * rate)) / rate)).astype(np.int16)


@pytest.mark.parametrize(("source", "target"), RATES)
def test_a_tone_keeps_frequency_and_amplitude_and_lags_by_the_stated_delay(source: int, target: int) -> None:
    resampler = Resampler(source, target)
    output = resampler.process(sine(1000, source)).astype(float)
    expected = 10000 * np.sin(2 * np.pi * 1000 * (np.arange(len(output)) / target - resampler.delay_s))
    steady = slice(round(3 * resampler.delay_s * target), None)
    assert np.abs(output - expected)[steady].max() < 20  # 0.2 %


@pytest.mark.parametrize(("source", "target"), [(48000, 16000), (16000, 8000), (44100, 16000)])
def test_what_the_lower_rate_cannot_hold_is_removed(source: int, target: int) -> None:
    output = Resampler(source, target).process(sine(0.62 * target, source))
    assert np.abs(output[len(output) // 4 :]).max() < 10  # -60 dB


@pytest.mark.slow
@given(lengths=st.lists(st.integers(0, 400), min_size=1, max_size=8), rates=st.sampled_from(RATES))
def test_blocks_leave_no_trace(lengths: list[int], rates: tuple[int, int]) -> None:
    sound = np.random.default_rng(1).integers(-20000, 20000, sum(lengths)).astype(np.int16)
    whole = Resampler(*rates).process(sound)
    streaming = Resampler(*rates)
    blocks = [streaming.process(block) for block in np.split(sound, np.cumsum(lengths)[:-1])]
    np.testing.assert_array_equal(np.concatenate(blocks), whole)
    assert len(whole) == -(-len(sound) * rates[1] // rates[0])


def test_full_scale_is_clipped_not_wrapped() -> None:
    square = np.repeat(np.array([32767, -32768] * 20, np.int16), 40)
    output = Resampler(16000, 48000).process(square).astype(int)
    assert output.max() == 32767 and output.min() == -32768
    assert np.abs(np.diff(output)).max() < 40000  # a wrap would jump by 65535


def test_rates_must_be_positive() -> None:
    with pytest.raises(ValueError, match="source_rate and target_rate must be positive"):
        Resampler(0, 16000)
