from pathlib import Path

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.head_pose import NEUTRAL_POSE
from conf.sender.motion_source import RecordedMotionSource, open_motion_file


def motion(frames: int = 4, points: int = 50, units: str = "fapu", *, poses: bool = True) -> MotionClip:
    displacements = np.arange(frames * points * 3, dtype=np.float32).reshape(frames, points, 3)
    return MotionClip(10.0, units, displacements, np.arange(frames * 6.0).reshape(frames, 6) if poses else None)


def test_a_recording_plays_at_its_rate_and_ends() -> None:
    performance = RecordedMotionSource(motion(), loop=False)
    stamps, shown = [], []
    while (stamp := performance.next_frame()) is not None:
        stamps.append(stamp)
        shown.append(performance.motion())
    assert stamps == pytest.approx([0, 0.1, 0.2, 0.3])
    assert [frame.timestamp for frame in shown] == pytest.approx(stamps)
    np.testing.assert_array_equal(shown[2].displacements, motion().displacements[2])
    np.testing.assert_array_equal(shown[2].pose, np.arange(12, 18))


def test_a_loop_goes_on_in_time() -> None:
    performance = RecordedMotionSource(motion(), loop=True)
    stamps = [performance.next_frame() for _ in range(10)]
    assert stamps == pytest.approx([i / 10 for i in range(10)])
    np.testing.assert_array_equal(performance.motion().displacements, motion().displacements[1])


def test_a_file_without_poses_looks_straight_ahead() -> None:
    performance = RecordedMotionSource(motion(poses=False), loop=False)
    performance.next_frame()
    np.testing.assert_array_equal(performance.motion().pose, NEUTRAL_POSE.to_vector())


@pytest.mark.parametrize(
    ("recording", "text"),
    [(motion(points=20), "expected 50 control points"), (motion(units="mesh"), "expected `# units: fapu`")],
)
def test_what_cannot_be_sent_is_refused_with_a_reason(recording: MotionClip, text: str, tmp_path: Path) -> None:
    write_dpc(tmp_path / "m.dpc", recording)
    with pytest.raises(FileFormatError, match=text):
        open_motion_file(tmp_path / "m.dpc", loop=False)
