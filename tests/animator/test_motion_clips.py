import math

import numpy as np
import pytest

from conf.animator.motion_clips import fit_to_aspect, make_expression_clip, peak_time, resample
from conf.animator.motion_player import REST_POSE
from conf.face.animation.action_units import load_emotions
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import displacements_at, duration_of
from conf.face.animation.timed_expression import Envelope
from conf.face.formats.dpc import MotionClip

JOY = load_emotions()["joy"]


def test_an_expression_clip_starts_and_ends_neutral_and_has_its_peak() -> None:
    envelope = Envelope(0.3, 1.0, 0.4)
    clip = make_expression_clip(JOY, envelope, fps=25.0)
    assert np.abs(clip.displacements[[0, -1]]).max() == 0
    np.testing.assert_allclose(displacements_at(clip, peak_time(envelope)), JOY, atol=1e-2)


def test_idle_motion_depends_on_the_seed() -> None:
    generators = [IdleMotion(np.random.default_rng(seed)) for seed in (1, 1, 2)]
    first, same, other = (make_expression_clip(JOY, Envelope(), fps=15.0, idle=idle) for idle in generators)
    np.testing.assert_array_equal(first.displacements, same.displacements)
    assert (first.displacements != other.displacements).any()


def test_an_envelope_without_end_is_refused() -> None:
    with pytest.raises(ValueError, match="envelope must end"):
        make_expression_clip(JOY, Envelope(hold=math.inf), fps=25.0)


def test_resampling_keeps_the_duration() -> None:
    values = np.zeros((31, 50, 3), np.float32)
    values[:, 3, 0] = np.arange(31)
    clip = MotionClip(30.0, "fapu", values, np.zeros((31, 6)))
    slow = resample(clip, 10.0)
    assert len(slow.displacements) == 11 and duration_of(slow) == pytest.approx(1.0)
    np.testing.assert_allclose(slow.displacements[:, 3, 0], np.arange(11) * 3, atol=1e-4)
    assert resample(clip, 30.0) is clip


def test_the_head_is_smaller_in_a_narrow_image() -> None:
    clip = MotionClip(10.0, "fapu", np.zeros((2, 50, 3), np.float32), np.zeros((2, 6)))
    narrow = fit_to_aspect(clip, (400, 1000))
    assert narrow.poses is not None and (narrow.poses[:, 5] == pytest.approx(math.log(0.5)))
    assert fit_to_aspect(clip, (1280, 720)) is clip
    without_poses = fit_to_aspect(MotionClip(10.0, "fapu", clip.displacements), (400, 1000))
    assert without_poses.poses is not None
    assert without_poses.poses[:, 5] == pytest.approx(REST_POSE.to_vector()[5] + math.log(0.5))
