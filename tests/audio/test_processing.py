"""The microphone's way: time stamps, levels, noise, pauses, echo; and what happens without the library."""

import sys
from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.audio.processing import BLOCK_SAMPLES, MISSING, VoiceBlock, VoiceProcessor
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, level_dbfs
from tests.support.synthetic_voice import noise, speech, tone, whisper

START = 50.0


def cut(sound: Samples) -> Iterator[AudioBlock]:
    """Yield blocks of 20 ms."""
    for first in range(0, len(sound), 320):
        yield AudioBlock(START + first / SAMPLE_RATE, sound[first : first + 320])


def run(processor: VoiceProcessor, sound: Samples) -> list[VoiceBlock]:
    return list(chain.from_iterable(map(processor.process, cut(sound))))


def join(blocks: list[VoiceBlock]) -> Samples:
    return np.concatenate([block.samples for block in blocks])


def silence(seconds: float) -> Samples:
    return noise(seconds, -75)


def test_blocks_follow_each_other_in_time() -> None:
    processor = VoiceProcessor()
    assert processor.fault is None
    first = processor.process(AudioBlock(START, speech(0.1)))
    assert len(first) == 10
    blocks = first + processor.process(AudioBlock(START + 0.1, speech(0.1)))
    assert len(blocks) == 20
    times = [block.timestamp for block in blocks]
    assert times[0] == pytest.approx(START - 0.006)
    assert np.diff(times) == pytest.approx(0.01)
    assert {(block.samples.dtype, block.samples.shape) for block in blocks} == {(np.dtype(np.int16), (BLOCK_SAMPLES,))}


def play_nothing() -> None:
    """Return what a speaker played that has not begun."""


@pytest.mark.parametrize("options", [{}, {"noise_suppression": False}, {"gain": False}, {"read_played": play_nothing}])
def test_time_stamps_account_for_the_delay_of_the_filters(options: dict[str, Any]) -> None:
    sound = speech(1.0, seed=2)
    blocks = run(VoiceProcessor(**options), sound)
    output = join(blocks).astype(float)
    size = 1 << 16
    products = np.fft.irfft(np.fft.rfft(output, size) * np.conj(np.fft.rfft(sound.astype(float), size)), size)
    lag = int(np.argmax(products[:1000]))
    assert blocks[0].timestamp == pytest.approx(START - lag / SAMPLE_RATE, abs=0.001)


@pytest.mark.slow
@given(counts=st.lists(st.integers(0, 700), min_size=1, max_size=12))
def test_blocks_of_any_length_give_the_same_sound(counts: list[int]) -> None:
    sound = speech(1.0, seed=4)[: sum(counts)]
    processor, blocks, position = VoiceProcessor(), list[VoiceBlock](), 0
    for count in counts:
        blocks += processor.process(AudioBlock(START + position / SAMPLE_RATE, sound[position : position + count]))
        position += len(sound[position : position + count])
    expected = run(VoiceProcessor(), sound[: len(sound) // BLOCK_SAMPLES * BLOCK_SAMPLES])
    assert [block.active for block in blocks] == [block.active for block in expected]
    assert [block.timestamp for block in blocks] == pytest.approx([block.timestamp for block in expected])
    assert all(np.array_equal(a.samples, b.samples) for a, b in zip(blocks, expected, strict=True))


def test_a_gap_in_time_is_kept() -> None:
    processor = VoiceProcessor(noise_suppression=False)
    blocks = processor.process(AudioBlock(START, speech(0.105)))
    blocks += processor.process(AudioBlock(START + 1, speech(0.1)))
    times = [block.timestamp for block in blocks]
    assert len(times) == 20  # the half block before the gap is dropped
    assert times[9] == pytest.approx(START + 0.09) and times[10] == pytest.approx(START + 1)


def test_activity_begins_with_the_first_loud_block_and_ends_250_ms_after_the_last() -> None:
    sound = np.concatenate([silence(2.0), tone(300, 0.5), silence(1.0)])
    blocks = run(VoiceProcessor(), sound)
    active = [block.timestamp - START for block in blocks if block.active and block.timestamp > START + 1.7]
    assert 1.985 <= active[0] <= 2.01
    assert 2.74 <= active[-1] <= 2.80
    assert np.diff(active) == pytest.approx(0.01)


@pytest.mark.slow
def test_soft_and_loud_talkers_come_out_alike() -> None:
    levels = []
    for amplitude in (1000, 8000, 32000):
        blocks = run(VoiceProcessor(), speech(15.0, seed=6, amplitude=amplitude))
        levels.append(level_dbfs(join(blocks[-300:])))
    assert max(levels) - min(levels) < 6
    assert -30 < min(levels) and max(levels) < -9


def test_gain_begins_at_1_less_the_headroom_of_6_db() -> None:
    sound = speech(0.5, seed=6, amplitude=16000)
    processor = VoiceProcessor(noise_suppression=False)
    assert level_dbfs(join(run(processor, sound))) == pytest.approx(level_dbfs(sound) - 6, abs=2.5)


@pytest.mark.slow
def test_steady_noise_is_reduced_and_its_level_reported() -> None:
    sound = noise(5.0, -50)
    quiet = VoiceProcessor(gain=False)
    level = level_dbfs(join(run(quiet, sound)[-100:]))
    assert level < -59
    assert quiet.noise_dbfs == pytest.approx(level, abs=1)
    kept = VoiceProcessor(gain=False, noise_suppression=False)
    assert level_dbfs(join(run(kept, sound)[-100:])) == pytest.approx(-50, abs=1)


def test_rumble_is_removed() -> None:
    blocks = run(VoiceProcessor(gain=False, noise_suppression=False), tone(20, 0.8))
    assert level_dbfs(join(blocks[-40:])) < level_dbfs(tone(20, 0.8)) - 20


@pytest.mark.slow
def test_the_played_sound_is_removed() -> None:
    played = whisper(8.0, seed=8, dbfs=-20)
    echo = np.concatenate([np.zeros(1280, np.int16), played[:-1280] // 2])  # 80 ms later, 6 dB quieter
    blocks = run(VoiceProcessor(gain=False, read_played=partial(next, cut(played))), echo)
    assert level_dbfs(join(blocks[-300:])) < level_dbfs(echo) - 25
    alone = run(VoiceProcessor(gain=False, read_played=play_nothing), speech(3.0, seed=9))
    assert level_dbfs(join(alone[-200:])) > level_dbfs(speech(3.0, seed=9)) - 4


def test_noise_level_of_nothing_is_silence() -> None:
    assert VoiceProcessor().noise_dbfs == -96.0


def test_without_the_library_sound_passes_and_pauses_are_still_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pywebrtc_audio", None)
    processor = VoiceProcessor()
    assert processor.fault == MISSING
    sound = np.concatenate([silence(1.0), speech(0.4), silence(1.0)])
    blocks = run(processor, sound)
    np.testing.assert_array_equal(join(blocks), sound)
    assert blocks[0].timestamp == START
    assert not blocks[50].active and blocks[110].active and not blocks[-1].active
