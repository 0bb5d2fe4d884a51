from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.head_pose import NEUTRAL_POSE
from conf.sender.capture.frame import Frame
from conf.sender.motion_source import RecordedMotionSource, TrackedMotionSource, open_motion_file


def clip(frames: int = 4, points: int = 50, units: str = "fapu", *, poses: bool = True) -> MotionClip:
    displacements = np.arange(frames * points * 3, dtype=np.float32).reshape(frames, points, 3)
    return MotionClip(10.0, units, displacements, np.arange(frames * 6.0).reshape(frames, 6) if poses else None)


def test_a_recording_plays_at_its_rate_and_ends() -> None:
    source = RecordedMotionSource(clip(), loop=False)
    timestamps, frames = [], []
    while (timestamp := source.next_frame()) is not None:
        timestamps.append(timestamp)
        frames.append(source.motion())
    assert timestamps == pytest.approx([0, 0.1, 0.2, 0.3])
    assert [frame.timestamp for frame in frames] == pytest.approx(timestamps)
    np.testing.assert_array_equal(frames[2].displacements, clip().displacements[2])
    np.testing.assert_array_equal(frames[2].pose, np.arange(12, 18))


def test_a_looped_recording_has_rising_timestamps() -> None:
    source = RecordedMotionSource(clip(), loop=True)
    timestamps = [source.next_frame() for _ in range(10)]
    assert timestamps == pytest.approx([i / 10 for i in range(10)])
    np.testing.assert_array_equal(source.motion().displacements, clip().displacements[1])


def test_a_file_without_poses_faces_the_camera() -> None:
    source = RecordedMotionSource(clip(poses=False), loop=False)
    source.next_frame()
    np.testing.assert_array_equal(source.motion().pose, NEUTRAL_POSE.to_vector())


@pytest.mark.parametrize(
    ("recording", "text"),
    [(clip(points=20), "expected 50 control points"), (clip(units="mesh"), "expected `# units: fapu`")],
)
def test_a_file_that_cannot_be_sent_is_refused_with_the_reason(
    recording: MotionClip, text: str, tmp_path: Path
) -> None:
    write_dpc(tmp_path / "m.dpc", recording)
    with pytest.raises(FileFormatError, match=text):
        open_motion_file(tmp_path / "m.dpc", loop=False)


def test_a_camera_is_shown_without_being_tracked_and_released() -> None:
    shown: list[tuple[float, object]] = []
    log: list[str] = []
    frame = Frame(np.zeros((4, 4, 3), np.uint8), 7.0)
    camera = SimpleNamespace(
        fps=30.0, size=(4, 4), is_live=True, read=lambda: frame, release=lambda: log.append("release")
    )
    source = TrackedMotionSource(
        camera,  # type: ignore[arg-type]
        SimpleNamespace(track=lambda pixels: log.append("track")),  # type: ignore[arg-type]
        SimpleNamespace(),  # type: ignore[arg-type]
        on_frame=lambda frame, tracked: shown.append((frame.timestamp, tracked)),
    )
    assert source.is_live and source.next_frame() == 7.0
    source.show()
    source.release()
    assert shown == [(7.0, None)] and log == ["release"]
    assert source.motion() is None and log == ["release", "track"] and len(shown) == 2


def test_a_recording_has_nothing_to_show_or_release() -> None:
    source = RecordedMotionSource(clip(), loop=False)
    source.next_frame()
    source.show()
    source.release()
    assert not source.is_live and source.motion().timestamp == 0.0
