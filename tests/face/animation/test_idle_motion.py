import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.animation.gaze import gaze_angles
from conf.face.animation.idle_motion import IdleMotion
from conf.face.control_points import CONTROL_POINT_INDEX

UPPER = [CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]]


def idle(seed: int = 7, intensity: float = 1.0) -> IdleMotion:
    return IdleMotion(np.random.default_rng(seed), intensity=intensity)


@pytest.mark.slow
@given(times=st.lists(st.floats(0, 60), min_size=1, max_size=6))
def test_motion_depends_on_seed_and_time_only(times: list[float]) -> None:
    motion = idle()
    for now in times:
        motion.at(now)
    for now in times:
        for found, expected in zip(motion.at(now), idle().at(now), strict=True):
            np.testing.assert_array_equal(found, expected)


def lid_track(seconds: float, fps: float = 200.0) -> np.ndarray:
    motion = idle(intensity=0.0)
    return np.array([motion.at(i / fps)[0][UPPER, 1] for i in range(int(seconds * fps))])


@pytest.mark.slow
def test_blink_rate_and_closed_time() -> None:
    closed = lid_track(120.0)[:, 0] < -1000
    blinks = np.count_nonzero(np.diff(closed.astype(int)) == 1)
    assert 14 <= blinks <= 60
    assert closed.mean() < 0.1


@pytest.mark.slow
def test_one_eye_blinks_a_few_milliseconds_later() -> None:
    left, right = lid_track(60.0, fps=1000.0).T
    starts = [np.flatnonzero(np.diff((track < -500).astype(int)) == 1) for track in (left, right)]
    assert len(starts[0]) == len(starts[1]) > 5
    lags = np.abs(starts[0] - starts[1])  # milliseconds
    assert lags.min() >= 3
    assert lags.max() <= 21


@pytest.mark.slow
def test_amplitudes_of_gaze_and_head() -> None:
    motion = idle()
    poses = np.array([motion.at(t)[1] for t in np.arange(0, 60, 0.1)])
    gazes = np.array([gaze_angles(motion.at(t)[0])[0] for t in np.arange(0, 60, 0.1)])
    assert 0.001 < poses[:, :3].std() < np.radians(3)
    assert np.abs(poses[:, 3:5]).max() < 0.01
    assert not poses[:, 5].any()
    assert np.radians(0.5) < gazes[:, 0].std() < np.radians(5)
    assert np.abs(gazes).max() < 0.2


@pytest.mark.slow
def test_motion_is_continuous() -> None:
    motion = idle()
    track = np.array([motion.at(t)[0] for t in np.arange(0, 20, 0.001)])
    fastest = np.abs(np.diff(track, axis=0)).max()
    assert fastest < 30  # FAPU units in a millisecond; a blink is 1,384


def test_at_intensity_0_only_the_lids_move() -> None:
    displacements, pose = idle(intensity=0.0).at(0.5)
    assert not pose.any()
    assert not displacements.any()
