"""The file is whole at any time, and at the end what a recording in memory would have been."""

from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import RecordingError
from conf.face.formats.dpc import DpcWriter, read_dpc
from conf.output import motion_file
from conf.output.motion_file import SETTLE_S, WRITE_INTERVAL_S, MotionFile
from conf.output.motion_recorder import MotionRecorder


def add(file: MotionFile, value: float, time: float, fps: float = 15) -> None:
    file.add(np.full((50, 3), value, np.float32), np.full(6, value / 100), time, fps=fps)


def values(path: Path) -> list[float]:
    return [round(float(value), 2) for value in read_dpc(path).displacements[:, 0, 0]]


def test_while_it_grows_the_partial_file_can_be_read_up_to_the_last_seconds(tmp_path: Path) -> None:
    file, partial = MotionFile(tmp_path / "call.dpc"), tmp_path / "call.partial.dpc"
    assert partial.exists()
    for number in range(150):
        add(file, number, 7 + number / 15)
        if number >= (SETTLE_S + WRITE_INTERVAL_S) * 15 + 1:
            recorded = values(partial)
            assert recorded == list(range(len(recorded)))
            assert number - len(recorded) <= (SETTLE_S + WRITE_INTERVAL_S) * 15 + 1
    assert len(file._waiting) <= (SETTLE_S + WRITE_INTERVAL_S) * 15 + 2, "memory does not grow"
    assert file.close() == tmp_path / "call.dpc"
    assert values(tmp_path / "call.dpc") == list(range(150)) and not partial.exists()


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.sampled_from([12.5, 15.0, 30.0]))
def test_it_is_what_a_recording_in_memory_would_be(
    tmp_path_factory: pytest.TempPathFactory, seed: int, fps: float
) -> None:
    """Frames are lost, late by up to a second and doubled, and the motion stops for seconds."""
    rng, folder = np.random.default_rng(seed), tmp_path_factory.mktemp("motion")
    numbers = np.flatnonzero(rng.random(300) < 0.8)
    numbers = numbers[(numbers < 80) | (numbers > rng.integers(80, 200))]
    arrival = numbers + rng.integers(0, int(fps), len(numbers))
    file, recorder = MotionFile(folder / "call.dpc"), MotionRecorder()
    for number in [*numbers[np.argsort(arrival, kind="stable")], int(numbers[-1])]:
        displacements, pose = np.full((50, 3), number * 0.5, np.float32), np.full(6, number / 100)
        file.add(displacements, pose, number / fps, fps=fps)
        recorder.add(displacements, pose, number / fps)
    path, expected = file.close(), recorder.finish(fps)
    assert path is not None and expected is not None and expected.poses is not None
    clip = read_dpc(path)
    assert clip.fps == fps and clip.poses is not None
    np.testing.assert_allclose(clip.displacements, expected.displacements, atol=0.0051)
    np.testing.assert_allclose(clip.poses, expected.poses, atol=1e-6)


def test_a_higher_frame_rate_later_keeps_every_frame(tmp_path: Path) -> None:
    file = MotionFile(tmp_path / "call.dpc")
    for number in range(90):
        add(file, 2 * number, number / 15)
    for number in range(180, 360):
        add(file, number, number / 30, fps=30)
    partial = read_dpc(tmp_path / "call.partial.dpc")
    assert partial.fps == 30 and len(partial.displacements) > 250
    path = file.close()
    assert path is not None and values(path) == list(range(360))
    assert [file.name for file in tmp_path.iterdir()] == ["call.dpc"]


def test_an_older_file_stays_until_the_new_one_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "call.dpc"
    path.write_text("older")
    file = MotionFile(path)
    for number in range(80):
        add(file, number, number / 15)
    assert path.read_text() == "older"
    file.close()
    assert values(path) == list(range(80))


def test_no_frames_leave_no_file(tmp_path: Path) -> None:
    assert MotionFile(tmp_path / "call.dpc").close() is None
    assert not list(tmp_path.iterdir())


def test_a_full_disk_keeps_what_was_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = MotionFile(tmp_path / "call.dpc")
    for number in range(60):
        add(file, number, number / 15)
    monkeypatch.setattr(DpcWriter, "write", Mock(side_effect=OSError(28, "No space left on device")))
    with pytest.raises(
        RecordingError, match=r"call\.dpc cannot be written \(No space left on device\); choose another f"
    ):
        for number in range(60, 90):
            add(file, number, number / 15)
    assert file.close() == tmp_path / "call.dpc"
    recorded = values(tmp_path / "call.dpc")
    assert recorded == list(range(len(recorded))) and len(recorded) >= 15


def test_a_folder_that_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="No such file or directory"):
        MotionFile(tmp_path / "none" / "call.dpc")


def test_an_interrupt_keeps_the_partial_file_and_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = MotionFile(tmp_path / "call.dpc")
    for number in range(60):
        add(file, number, number / 15)
    monkeypatch.setattr(motion_file, "resample", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt) as raised:
        file.close()
    assert raised.value.__notes__ == [f"what was written so far is in {tmp_path / 'call.partial.dpc'}"]
    assert values(tmp_path / "call.partial.dpc")


def test_recording_stops_at_its_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion_file, "MAX_FRAMES", 50)
    file = MotionFile(tmp_path / "call.dpc")
    for number in range(60):
        assert file.is_full is (number >= 50)
        add(file, number, number / 15)
    path = file.close()
    assert path is not None and values(path) == list(range(50))
    file = MotionFile(tmp_path / "gap.dpc")
    for time in (0.0, 1e6, 2e6):  # a gap cannot make a longer file either
        add(file, 0.0, time)
    path = file.close()
    assert path is not None and len(values(path)) == 50
