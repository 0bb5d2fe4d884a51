import math
from pathlib import Path

import numpy as np
import pytest

from conf.animator.motion_player import (
    REST_POSE,
    MotionPlayer,
    fit_to_aspect,
    load_motion_clip,
    make_expression_clip,
    peak_time,
    recentre,
    resample,
    sample_clip,
)
from conf.errors import ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.animation.playback import displacements_at, duration_of
from conf.face.animation.timed_expression import Envelope
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.render.auto_framing import CENTRE, LOG_SCALE


def make_clip(frames: int = 11, points: int = 50, units: str = "fapu") -> MotionClip:
    values = np.zeros((frames, points, 3), np.float32)
    values[:, 0, 1] = np.arange(frames)
    poses = np.zeros((frames, 6))
    poses[:, 3:5], poses[:, 5] = [0.2, -0.1], -3.0
    return MotionClip(10.0, units, values, poses)


def test_recentring_moves_the_head_to_the_centre() -> None:
    clip = recentre(make_clip())
    assert clip.poses is not None
    np.testing.assert_allclose(clip.poses[:, 3:5], np.tile(CENTRE, (11, 1)), atol=1e-12)
    np.testing.assert_allclose(clip.poses[:, 5], LOG_SCALE)


def test_play_pause_step_and_speed() -> None:
    player = MotionPlayer("a", make_clip(), loop=False)
    player.toggle(0.0)
    assert player.is_playing(0.1) and player.frame(0.55) == 5
    player.toggle(0.55)
    assert not player.is_playing(0.6)
    player.step(1, 10.0, 0.6)
    assert player.frame(9.0) == 6
    player.step(-2, 10.0, 9.0)
    assert player.frame(9.0) == 4
    assert player.at(9.0).displacements[0, 1] == pytest.approx(4.0, abs=1e-5)
    player.set_speed(2.0, 10.0)
    player.toggle(10.0)
    assert player.frame(10.2) == 8
    assert not player.is_playing(11.0)


def test_a_clip_without_poses_has_the_rest_pose() -> None:
    assert sample_clip(MotionClip(10.0, "fapu", make_clip().displacements), 0.0).pose is REST_POSE


def test_mesh_units_are_converted_to_fapu(tmp_path: Path, head: FaceModel) -> None:
    write_dpc(tmp_path / "a.dpc", make_clip(units="mesh"))
    clip = load_motion_clip(tmp_path / "a.dpc", head.fapu)
    assert clip.units == "fapu"
    np.testing.assert_allclose(clip.displacements[5, 0, 1] * head.fapu.lengths()[0, 1], 5.0, rtol=1e-4)


def test_another_number_of_points_is_refused(tmp_path: Path, head: FaceModel) -> None:
    write_dpc(tmp_path / "a.dpc", make_clip(points=3))
    with pytest.raises(ConfError, match=r"a\.dpc moves 3 control points: only motions of 50 can be played"):
        load_motion_clip(tmp_path / "a.dpc", head.fapu)


JOY = load_emotions()["joy"]


def test_an_expression_clip_starts_and_ends_neutral_and_has_its_peak() -> None:
    envelope = Envelope(0.3, 1.0, 0.4)
    clip = make_expression_clip([JOY], envelope, fps=25.0, idle=False)
    assert np.abs(clip.displacements[[0, -1]]).max() == 0
    np.testing.assert_allclose(displacements_at(clip, peak_time(envelope)), JOY, atol=1e-2)


def test_every_expression_has_the_same_idle_motion() -> None:
    with_idle, still = (make_expression_clip([JOY, JOY], Envelope(), fps=15.0, idle=idle) for idle in (True, False))
    first, second = np.split(with_idle.displacements, 2)
    np.testing.assert_array_equal(first, second)
    assert (with_idle.displacements != still.displacements).any()


def test_an_envelope_without_end_is_refused() -> None:
    with pytest.raises(ValueError, match="envelope must end"):
        make_expression_clip([JOY], Envelope(hold=math.inf), fps=25.0, idle=False)


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
