"""When speech is noticed: by level, by probability, with a hangover, above any background."""

import numpy as np
import pytest

from conf.audio.voice_activity import HANGOVER_FRAMES, VoiceActivity


def run(levels: list[float], probabilities: list[float] | None = None) -> list[bool]:
    activity = VoiceActivity()
    pairs = zip(levels, probabilities or [0.0] * len(levels), strict=True)
    return [activity.update(level, probability) for level, probability in pairs]


def background(dbfs: float, frames: int) -> list[float]:
    return [dbfs + float(x) for x in np.random.default_rng(1).normal(0, 1, frames)]


def test_the_first_loud_frame_is_speech() -> None:
    assert run([-95.0, -30.0]) == [False, True]


@pytest.mark.parametrize("dbfs", [-75.0, -55.0, -40.0, -30.0])
def test_a_steady_background_is_silence_within_two_seconds_whatever_its_level(dbfs: float) -> None:
    assert not any(run(background(dbfs, 400))[180:])


@pytest.mark.parametrize("dbfs", [-75.0, -55.0, -40.0])
def test_speech_15_db_above_the_background_is_noticed_at_once(dbfs: float) -> None:
    speech = max(dbfs + 16, -55.0)
    decisions = run([*background(dbfs, 300), *[speech] * 5])
    assert decisions[299:302] == [False, True, True]


def test_the_hangover_keeps_250_ms_and_no_more() -> None:
    decisions = run([*[-70.0] * 200, *[-30.0] * 50, *[-70.0] * 100])
    assert HANGOVER_FRAMES == 25
    assert all(decisions[200 : 250 + 24]) and not any(decisions[250 + 25 :])


def test_a_stop_inside_a_word_is_bridged() -> None:
    word = [*[-30.0] * 20, *[-70.0] * 15, *[-28.0] * 20]
    assert all(run([*[-70.0] * 200, *word])[200:])


def test_soft_speech_needs_the_probability() -> None:
    soft = [*background(-66.0, 300), *[-57.0] * 10]
    assert not any(run(soft)[300:])
    assert all(run(soft, [0.0] * 300 + [0.9] * 10)[300:])
    assert not any(run(background(-66.0, 310), [0.9] * 310)[300:])  # probable, but no louder than the background


def test_a_background_that_becomes_louder_is_learnt() -> None:
    decisions = run([*background(-70.0, 300), *background(-40.0, 400)])
    assert decisions[300] and not any(decisions[500:])
