from pathlib import Path

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.formats.dpc import Motion, write_dpc
from conf.face.head_pose import NEUTRAL_POSE
from conf.sender.motion_source import RecordedPerformance, open_recording


def motion(frames: int = 4, points: int = 50, units: str = "fapu", *, poses: bool = True) -> Motion:
    displacements = np.arange(frames * points * 3, dtype=np.float32).reshape(frames, points, 3)
    return Motion(10.0, units, displacements, np.arange(frames * 6.0).reshape(frames, 6) if poses else None)


def test_a_recording_plays_at_its_rate_and_ends() -> None:
    performance = RecordedPerformance(motion(), loop=False)
    stamps, shown = [], []
    while (stamp := performance.advance()) is not None:
        stamps.append(stamp)
        shown.append(performance.motion())
    assert stamps == pytest.approx([0, 0.1, 0.2, 0.3])
    assert [frame.timestamp for frame in shown] == pytest.approx(stamps)
    np.testing.assert_array_equal(shown[2].displacements, motion().displacements[2])
    np.testing.assert_array_equal(shown[2].pose, np.arange(12, 18))


def test_a_loop_goes_on_in_time() -> None:
    performance = RecordedPerformance(motion(), loop=True)
    stamps = [performance.advance() for _ in range(10)]
    assert stamps == pytest.approx([i / 10 for i in range(10)])
    np.testing.assert_array_equal(performance.motion().displacements, motion().displacements[1])


def test_a_file_without_poses_looks_straight_ahead() -> None:
    performance = RecordedPerformance(motion(poses=False), loop=False)
    performance.advance()
    np.testing.assert_array_equal(performance.motion().pose, NEUTRAL_POSE.to_vector())


@pytest.mark.parametrize(
    ("recording", "text"),
    [(motion(points=20), "expected 50 control points"), (motion(units="mesh"), "expected `# units: fapu`")],
)
def test_what_cannot_be_sent_is_refused_with_a_reason(recording: Motion, text: str, tmp_path: Path) -> None:
    write_dpc(tmp_path / "m.dpc", recording)
    with pytest.raises(FileFormatError, match=text):
        open_recording(tmp_path / "m.dpc", loop=False)
