from pathlib import Path

import pytest

from conf.errors import CameraError
from conf.sender.tracking.offline import track_clip
from tests.support.short_clips import SHORT


def test_every_frame_is_tracked_and_progress_is_reported(short_clip: Path) -> None:
    done: list[int] = []
    tracked = list(track_clip(short_clip, done.append))
    assert done == list(range(1, SHORT + 1))
    assert [frame.timestamp for frame, _ in tracked] == pytest.approx([i / 30 for i in range(SHORT)], abs=0.002)
    assert all(tracking is not None and tracking.landmarks.shape == (478, 3) for _, tracking in tracked)


def test_frames_without_a_face(empty_clip: Path) -> None:
    assert [tracking for _, tracking in track_clip(empty_clip)] == [None] * 3


def test_a_missing_clip_is_reported() -> None:
    with pytest.raises(CameraError, match=r"there is no file nosuch\.avi"):
        list(track_clip(Path("nosuch.avi")))
