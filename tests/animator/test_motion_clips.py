import math

import numpy as np
import pytest

from conf.animator.motion_clips import fit_to_aspect, make_expression_clip, peak_time, resample
from conf.face.animation.action_units import load_emotions
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import displacements_at, duration_of
from conf.face.animation.timed_expression import Envelope
from conf.face.formats.dpc import MotionClip

JOY = load_emotions()["joy"]


def test_an_emotions_motion_begins_and_ends_neutral_and_is_whole_at_its_peak() -> None:
    envelope = Envelope(0.3, 1.0, 0.4)
    motion = make_expression_clip(JOY, envelope, fps=25.0)
    assert np.abs(motion.displacements[[0, -1]]).max() == 0
    np.testing.assert_allclose(displacements_at(motion, peak_time(envelope)), JOY, atol=1e-2)


def test_idle_life_is_the_generators() -> None:
    lives = [IdleMotion(np.random.default_rng(seed)) for seed in (1, 1, 2)]
    first, same, other = (make_expression_clip(JOY, Envelope(), fps=15.0, idle=life) for life in lives)
    np.testing.assert_array_equal(first.displacements, same.displacements)
    assert (first.displacements != other.displacements).any()


def test_an_emotion_that_stays_for_ever_is_refused() -> None:
    with pytest.raises(ValueError, match="envelope must end"):
        make_expression_clip(JOY, Envelope(hold=math.inf), fps=25.0)


def test_another_rate_keeps_the_time() -> None:
    values = np.zeros((31, 50, 3), np.float32)
    values[:, 3, 0] = np.arange(31)
    motion = MotionClip(30.0, "fapu", values, np.zeros((31, 6)))
    slow = resample(motion, 10.0)
    assert len(slow.displacements) == 11 and duration_of(slow) == pytest.approx(1.0)
    np.testing.assert_allclose(slow.displacements[:, 3, 0], np.arange(11) * 3, atol=1e-4)
    assert resample(motion, 30.0) is motion


def test_a_tall_picture_shows_a_smaller_head() -> None:
    motion = MotionClip(10.0, "fapu", np.zeros((2, 50, 3), np.float32), np.zeros((2, 6)))
    narrow = fit_to_aspect(motion, (400, 1000))
    assert narrow.poses is not None and (narrow.poses[:, 5] < 0).all()
    assert fit_to_aspect(motion, (1280, 720)) is motion
