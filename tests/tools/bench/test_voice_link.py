"""A simulated call with a synthetic voice whose lips move with it: what is heard, when, and at which rate."""

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, Samples, to_int16
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.fapu import Fapu
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import TYPICAL_POSE
from tests.support.synthetic_voice import vowel
from tools.bench.tracks import Track
from tools.bench.voice_link import Loss, VoiceCall, align, call

FPS, SECONDS, SETTLE_S = 30.0, 9.0, 2.0
LIP = CONTROL_POINT_INDEX["inner_lip_lower_mid"]
SILENCE_LOG = np.log(30.0)  # amplitude below which the mouth is shut


def slow_speech(seconds: float) -> Samples:
    """Return vowels that last longer than several frames of motion, with pauses."""
    rng = np.random.default_rng(4)
    parts: list[NDArray[np.float64]] = []
    while sum(map(len, parts)) < seconds * SAMPLE_RATE:
        sound = vowel(int(rng.integers(4)), rng.uniform(0.25, 0.5), pitch=rng.uniform(90, 220)).astype(float)
        parts += [sound * np.hanning(len(sound)), np.zeros(int(rng.uniform(0.1, 0.35) * SAMPLE_RATE))]
    return to_int16(np.concatenate(parts)[: round(seconds * SAMPLE_RATE)])


VOICE = slow_speech(SECONDS + 1)


def opening(sound: NDArray[np.integer], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the logarithm of the amplitude within 20 ms of each time."""
    half = SAMPLE_RATE // 50
    middles = np.clip((times * SAMPLE_RATE).astype(int), half, len(sound) - half)
    squares = np.concatenate([[0.0], np.cumsum(sound.astype(float) ** 2)])
    power = (squares[middles + half] - squares[middles - half]) / (2 * half)
    return np.maximum(0.5 * np.log(power + 1.0), SILENCE_LOG) - SILENCE_LOG


def speaking_face() -> Track:
    """Return a face that opens its mouth as far as VOICE is loud."""
    times = np.arange(int(len(VOICE) / SAMPLE_RATE * FPS)) / FPS
    frames = []
    for timestamp, wide in zip(times, opening(VOICE, times), strict=True):
        displacements = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
        displacements[LIP, 1] = -80 * wide
        frames.append(MotionFrame(float(timestamp), displacements, TYPICAL_POSE))
    return Track("speaking", frames, np.full(len(frames), 0.2), Fapu(6, 6, 6, 6, 6))


@pytest.mark.parametrize("late", [0, 5, 4001])
def test_sounds_are_aligned_although_one_is_softer_and_of_other_phases(late: int) -> None:
    captured, size = VOICE[:32000], 40000
    other = np.convolve(VOICE[:size], np.random.default_rng(1).standard_normal(32) * np.hanning(32), mode="same") * 0.1
    for sound, tolerance in ((other, 16), (VOICE[:size], 12)):
        later = np.concatenate([np.zeros(late), sound])[:size]
        assert align(captured, later, max_samples=8000) == pytest.approx(late, abs=tolerance)


def heard(made: VoiceCall) -> Samples:
    """Return what is heard, from time 0 on."""
    return np.concatenate([np.zeros(round(made.heard_at * SAMPLE_RATE), np.int16), *made.heard])


def correlate(
    values: NDArray[np.float64], times: NDArray[np.float64], sound: Samples, lags: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the lag at which values at times resemble the loudness of a sound best, s, and their correlation."""
    scores = [float(np.corrcoef(values, opening(sound, times + lag))[0, 1]) for lag in lags]
    return float(lags[int(np.argmax(scores))]), max(scores)


@pytest.mark.slow
@pytest.mark.parametrize(("kbps", "loss"), [(16.0, 0.0), (9.6, 0.0), (4.8, 0.0), (2.4, 0.1)])
def test_voice_and_lips_arrive_together_within_the_rate(kbps: float, loss: float) -> None:
    made = call(speaking_face(), VOICE, seconds=SECONDS, kbps=kbps, loss=Loss(loss), seed=4, fps=FPS)
    assert made.worst_kbps <= kbps
    times = np.arange(SETTLE_S, SECONDS - 1, 0.01)
    lag, resemblance = correlate(opening(VOICE, times), times, heard(made), np.arange(0, 0.9, 0.01))
    assert resemblance > (0.6 if loss else 0.8)
    assert lag < 0.04 + 0.48 + 0.15  # the network, the longest packet, the program
    drawn = [(at, -float(displacements[LIP, 1])) for at, displacements in made.shown if at > SETTLE_S]
    at, lips = np.array(drawn[:-25]).T
    skew, resemblance = correlate(lips, at, heard(made), np.arange(-0.3, 0.3, 0.01))
    assert resemblance > 0.6
    assert abs(skew) < 0.045  # from there on early sound is noticed (ITU-R BT.1359-1); late sound much later
