"""What is recorded is what arrived: each frame once, at its time."""

from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from conf.errors import RecordingError
from conf.face.formats.dpc import read_dpc
from conf.output import motion_file
from conf.protocol.messages import MotionFrame
from conf.protocol.motion.inbound import ReceivedFrame
from conf.receiver.call_recorder import CallRecorder
from tests.support.simulated_calls import Line, SimulatedSender, World


def received(number: int, value: float, fps: int = 15) -> ReceivedFrame:
    frame = MotionFrame(number / fps, np.full((50, 3), value, np.float32), np.full(6, value / 100))
    return ReceivedFrame(frame, fps)


def values(path: Path) -> list[float]:
    return [round(float(value), 3) for value in read_dpc(path).displacements[:, 0, 0]]


def test_each_frame_is_in_the_file_once_at_the_senders_frame_rate(tmp_path: Path) -> None:
    recorder = CallRecorder(tmp_path)
    for number in (3, 4, 6, 5, 4, 7):  # one comes late, one twice
        recorder.add(1, [received(number, 10.0 * number)])
    (path,) = recorder.close()
    assert path == tmp_path / "conf-001.dpc" and read_dpc(path).fps == 15
    assert values(path) == [30, 40, 50, 60, 70]


def test_a_lost_frame_is_interpolated_and_a_long_gap_holds_until_the_motion_goes_on(tmp_path: Path) -> None:
    recorder = CallRecorder(tmp_path)
    recorder.add(1, [received(0, 0.0), received(2, 20.0), received(32, 320.0)])
    (path,) = recorder.close()
    recorded = values(path)
    assert recorded[:3] == [0, 10, 20] and len(recorded) == 33 and recorded[-1] == 320
    assert recorded[2:29] == [20.0] * 27  # until a quarter of a second before the end


def test_a_change_of_the_frame_rate_keeps_every_frame(tmp_path: Path) -> None:
    recorder = CallRecorder(tmp_path)
    recorder.add(1, [received(0, 0.0), received(1, 10.0), received(3, 25.0, fps=30), received(4, 50.0, fps=30)])
    (path,) = recorder.close()
    assert read_dpc(path).fps == 30 and values(path) == [0, 5, 10, 25, 50]


def test_each_caller_has_a_file(tmp_path: Path) -> None:
    recorder = CallRecorder(tmp_path)
    recorder.add(1, [received(0, 1.0)])
    recorder.add(2, [received(100, 2.0)])
    recorder.add(3, [])
    paths = recorder.close()
    assert [path.name for path in paths] == ["conf-001.dpc", "conf-002.dpc"]
    assert [values(path) for path in paths] == [[1.0], [2.0]]


def test_nothing_received_saves_nothing(tmp_path: Path) -> None:
    assert CallRecorder(tmp_path).close() == [] and not list(tmp_path.iterdir())


def test_it_is_full_after_an_hour(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(motion_file, "MAX_FRAMES", 2)
    recorder = CallRecorder(tmp_path)
    recorder.add(1, [received(0, 1.0)])
    assert not recorder.is_full
    recorder.add(1, [received(1, 1.0)])
    assert recorder.is_full


def test_a_file_that_cannot_be_completed_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = CallRecorder(tmp_path)
    recorder.add(1, [received(0, 1.0)])
    recorder.add(2, [received(0, 2.0)])
    monkeypatch.setattr(recorder._files[1], "close", Mock(side_effect=RecordingError("the disk is full")))
    with pytest.raises(RecordingError, match="the disk is full"):
        recorder.close()
    assert values(tmp_path / "conf-002.dpc") == [2.0]


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.0, 0.1])
def test_the_frames_of_a_call_are_recorded_whatever_is_drawn(tmp_path: Path, loss: float) -> None:
    """A window that draws once a second records as much as one that draws always: nothing is repeated or missing."""
    world = World()
    caller: SimulatedSender = world.call(line=Line(loss=loss, jitter_s=0.03))
    world.run(2)
    recorder, count = CallRecorder(tmp_path), 0
    world.stream(caller).motion.received.clear()
    for _ in range(10):
        world.run(1)
        frames = world.stream(caller).motion.received
        count += len(frames)
        recorder.add(1, frames)
        frames.clear()
    (path,) = recorder.close()
    clip = read_dpc(path)
    assert clip.fps == 15 and len(clip.displacements) == pytest.approx(150, abs=4)
    assert 0.65 * 150 * (1 - loss) < count <= 150  # a frame that hardly differs from the last is not sent
    distinct = len({frame.tobytes() for frame in clip.displacements})
    assert distinct > 0.97 * count  # a face may stand still for a frame
