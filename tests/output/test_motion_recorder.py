from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import RecordingError
from conf.face.formats.dpc import read_dpc
from conf.output import motion_recorder
from conf.output.motion_recorder import FPS, MotionRecorder


def add(recorder: MotionRecorder, value: float, now: float) -> None:
    recorder.add(np.full((50, 3), value, np.float32), np.full(6, value / 100), now)


def test_the_file_plays_at_the_speed_of_what_was_shown(tmp_path: Path) -> None:
    recorder = MotionRecorder()
    for count in range(61):  # 60 frames a second for a second, then one frame half a second later
        add(recorder, count, 100 + count / 60)
    add(recorder, 99.0, 101.5)
    assert recorder.save(tmp_path / "call.dpc") == tmp_path / "call.dpc"
    motion = read_dpc(tmp_path / "call.dpc")
    assert motion.fps == FPS and motion.units == "fapu"
    assert len(motion.displacements) == pytest.approx(1.5 * FPS + 1, abs=1)
    assert motion.displacements[10, 0, 0] == pytest.approx(20, abs=1)
    assert motion.poses is not None and motion.poses[-1, 0] == pytest.approx(0.99, abs=0.03)


def test_motion_shown_at_uneven_times_is_resampled_evenly() -> None:
    recorder = MotionRecorder()
    for time in np.cumsum(np.random.default_rng(3).uniform(0.005, 0.06, 60)):
        add(recorder, 100 * time, float(time))
    clip = recorder.finish()
    assert clip is not None and clip.poses is not None
    np.testing.assert_allclose(np.diff(clip.displacements[:, 0, 0]), 100 / FPS, rtol=1e-3)
    np.testing.assert_allclose(np.diff(clip.poses[:, 0]), 1 / FPS, rtol=1e-3)


def test_recording_stops_at_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion_recorder, "MAX_FRAMES", 10)
    recorder = MotionRecorder()
    for count in range(12):
        assert recorder.is_full is (count >= 10)
        add(recorder, count, count / FPS)
    clip = recorder.finish()
    assert clip is not None and len(clip.displacements) == 10
    recorder = MotionRecorder()
    for now in (0.0, 1e6):  # a gap cannot make a longer clip either
        add(recorder, now, now)
    clip = recorder.finish()
    assert clip is not None and len(clip.displacements) == 10


def test_what_was_added_may_change_afterwards() -> None:
    recorder, displacements, pose = MotionRecorder(), np.ones((50, 3), np.float32), np.ones(6)
    recorder.add(displacements, pose, 0.0)
    displacements[:] = pose[:] = 5
    clip = recorder.finish()
    assert clip is not None and clip.poses is not None
    assert (clip.displacements == 1).all() and (clip.poses == 1).all()


@pytest.mark.slow
@given(st.lists(st.integers(0, 200), min_size=1, max_size=40, unique=True), st.sampled_from([15, 24, 30]))
def test_frames_on_the_grid_are_kept_unchanged_in_any_order(numbers: list[int], fps: int) -> None:
    recorder = MotionRecorder()
    for number in numbers:
        add(recorder, float(number), 7 + number / fps)
    clip = recorder.finish(fps)
    assert clip is not None and len(clip.displacements) == max(numbers) - min(numbers) + 1
    for number in numbers:
        assert clip.displacements[number - min(numbers), 0, 0] == number


def test_an_empty_recording_writes_no_file(tmp_path: Path) -> None:
    assert MotionRecorder().finish() is None
    assert MotionRecorder().save(tmp_path / "call.dpc") is None
    assert not list(tmp_path.iterdir())


def test_an_unwritable_folder_is_named(tmp_path: Path) -> None:
    recorder = MotionRecorder()
    add(recorder, 1.0, 0.0)
    with pytest.raises(RecordingError, match=r"none/call\.dpc cannot be written"):
        recorder.save(tmp_path / "none" / "call.dpc")
