"""The suppressor removes residual echo, keeps near voices, and passes sound unchanged without an echo."""

import numpy as np
from numpy.typing import NDArray

from conf.audio.echo_suppressor import BINS, HOP, EchoSuppressor
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE
from tests.support.synthetic_voice import whisper

ECHO = (whisper(2.0, seed=1) / FULL_SCALE).astype(np.float32)
RESIDUAL = np.float32(0.1) * np.roll(ECHO, 50)
NOTHING = np.zeros(BINS, np.float32)


def run(
    suppressor: EchoSuppressor, error: NDArray[np.float32], echo: NDArray[np.float32], expected: NDArray[np.float32]
) -> NDArray[np.float32]:
    hops = zip(error.reshape(-1, HOP), echo.reshape(-1, HOP), strict=True)
    return np.concatenate([suppressor.process(*hop, expected) for hop in hops])


def level_db(sound: NDArray[np.float32]) -> float:
    return float(10 * np.log10(np.mean(np.square(sound)) + 1e-12))


def test_without_an_echo_the_sound_is_one_hop_late_and_else_unchanged() -> None:
    sound = run(EchoSuppressor(), ECHO, np.zeros_like(ECHO), NOTHING)
    np.testing.assert_allclose(sound[HOP:], ECHO[:-HOP], atol=2e-5)


def test_what_is_left_of_an_echo_is_attenuated() -> None:
    output = run(EchoSuppressor(), RESIDUAL, ECHO, NOTHING)
    assert level_db(output[SAMPLE_RATE:]) < level_db(RESIDUAL[SAMPLE_RATE:]) - 8


def test_what_the_filter_expects_to_be_left_is_attenuated() -> None:
    power = np.abs(np.fft.rfft(RESIDUAL[: SAMPLE_RATE // HOP * HOP].reshape(-1, HOP), 2 * HOP)) ** 2
    output = run(EchoSuppressor(), RESIDUAL, np.zeros_like(ECHO), power.mean(axis=0).astype(np.float32))
    assert level_db(output[SAMPLE_RATE:]) < level_db(RESIDUAL[SAMPLE_RATE:]) - 10


def test_a_near_voice_is_kept_once_the_leakage_is_known() -> None:
    suppressor = EchoSuppressor()
    run(suppressor, RESIDUAL, ECHO, NOTHING)
    near = (whisper(2.0, seed=3) / FULL_SCALE).astype(np.float32)
    output = run(suppressor, near + RESIDUAL, ECHO, NOTHING)
    assert abs(level_db(output) - level_db(near)) < 1.5
    assert np.corrcoef(output[HOP:], near[:-HOP])[0, 1] > 0.95


def test_after_a_reset_nothing_is_trusted() -> None:
    suppressor = EchoSuppressor()
    run(suppressor, RESIDUAL, ECHO, NOTHING)
    suppressor.reset()
    output = run(suppressor, ECHO[:4800], ECHO[:4800], NOTHING)
    assert level_db(output[HOP:]) < level_db(ECHO[:4800]) - 20


def test_bypassing_and_processing_join_without_a_seam() -> None:
    suppressor, parts = EchoSuppressor(), []
    hops = ECHO[: 40 * HOP].reshape(-1, HOP)
    for number, hop in enumerate(hops):
        is_bypassed = number // 10 % 2 == 0
        parts.append(suppressor.bypass(hop) if is_bypassed else suppressor.process(hop, np.zeros_like(hop), NOTHING))
    np.testing.assert_allclose(np.concatenate(parts)[HOP:], ECHO[: 39 * HOP], atol=2e-5)
