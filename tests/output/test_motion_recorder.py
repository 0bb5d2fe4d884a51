from pathlib import Path

import numpy as np
import pytest

from conf.errors import RecordingError
from conf.face.formats.dpc import read_dpc
from conf.output.motion_recorder import FPS, MotionRecorder
from conf.protocol.messages import MotionFrame


def frame(value: float) -> MotionFrame:
    return MotionFrame(value, np.full((50, 3), value, np.float32), np.full(6, value / 100))


def test_what_is_shown_is_what_the_file_plays_at_its_true_speed(tmp_path: Path) -> None:
    recorder = MotionRecorder(tmp_path / "call.dpc")
    for count in range(61):  # pictures come at 60 a second for a second, the last of them half a second late
        recorder.add(frame(count), 100 + count / 60)
    recorder.add(frame(99.0), 101.5)
    assert recorder.close() == tmp_path / "call.dpc"
    motion = read_dpc(tmp_path / "call.dpc")
    assert motion.fps == FPS and motion.units == "fapu"
    assert len(motion.displacements) == pytest.approx(1.5 * FPS + 1, abs=1)
    assert motion.displacements[10, 0, 0] == pytest.approx(20, abs=1)
    assert motion.poses is not None and motion.poses[-1, 0] == pytest.approx(0.99)


def test_nothing_shown_is_nothing_written(tmp_path: Path) -> None:
    assert MotionRecorder(tmp_path / "call.dpc").close() is None
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    recorder = MotionRecorder(tmp_path / "none" / "call.dpc")
    recorder.add(frame(1.0), 0.0)
    with pytest.raises(RecordingError, match="cannot be written"):
        recorder.close()
