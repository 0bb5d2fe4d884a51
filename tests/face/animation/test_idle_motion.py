import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conf.face.animation.gaze import gaze_angles
from conf.face.animation.idle_motion import IdleMotion
from conf.face.control_points import CONTROL_POINT_INDEX

UPPER = [CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]]


def idle(seed: int = 7, amount: float = 1.0) -> IdleMotion:
    return IdleMotion(np.random.default_rng(seed), intensity=amount)


@given(times=st.lists(st.floats(0, 60), min_size=1, max_size=6))
def test_the_same_seed_gives_the_same_life_however_it_is_asked(times: list[float]) -> None:
    asked = idle()
    for now in times:
        asked.at(now)
    for now in times:
        again = idle().at(now)
        np.testing.assert_array_equal(asked.at(now).displacements, again.displacements)
        np.testing.assert_array_equal(asked.at(now).pose, again.pose)


def lid_track(seconds: float, fps: float = 200.0) -> np.ndarray:
    motion = idle(amount=0.0)
    return np.array([motion.at(i / fps).displacements[UPPER, 1] for i in range(int(seconds * fps))])


def test_eyes_blink_some_times_a_minute_and_close() -> None:
    shut = lid_track(120.0)[:, 0] < -1000
    blinks = np.count_nonzero(np.diff(shut.astype(int)) == 1)
    assert 14 <= blinks <= 60
    assert shut.mean() < 0.1


def test_one_eye_is_a_few_milliseconds_behind() -> None:
    left, right = lid_track(60.0, fps=1000.0).T
    starts = [np.flatnonzero(np.diff((track < -500).astype(int)) == 1) for track in (left, right)]
    assert len(starts[0]) == len(starts[1]) > 5
    lags = np.abs(starts[0] - starts[1])  # milliseconds
    assert lags.min() >= 3
    assert lags.max() <= 21


def test_gaze_and_head_move_a_little() -> None:
    motion = idle()
    poses = np.array([motion.at(t).pose for t in np.arange(0, 60, 0.1)])
    gazes = np.array([gaze_angles(motion.at(t).displacements)[0] for t in np.arange(0, 60, 0.1)])
    assert 0.001 < poses[:, :3].std() < np.radians(3)
    assert np.abs(poses[:, 3:5]).max() < 0.01
    assert not poses[:, 5].any()
    assert np.radians(0.5) < gazes[:, 0].std() < np.radians(5)
    assert np.abs(gazes).max() < 0.2


def test_nothing_jumps() -> None:
    motion = idle()
    track = np.array([motion.at(t).displacements for t in np.arange(0, 20, 0.001)])
    fastest = np.abs(np.diff(track, axis=0)).max()
    assert fastest < 30  # of a lid's 1,384 units in a millisecond


def test_without_amount_only_the_lids_move() -> None:
    still = idle(amount=0.0).at(0.5)
    assert not still.pose.any()
    assert not still.displacements.any()
