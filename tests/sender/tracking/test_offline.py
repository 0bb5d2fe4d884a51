from pathlib import Path

import numpy as np
import pytest

from conf.errors import CameraError
from conf.sender.tracking.offline import EVEN_S, MAX_FPS, to_even_rate, track_clip
from tests.support.short_clips import SHORT


@pytest.mark.slow
def test_every_frame_is_tracked_and_progress_is_reported(short_clip: Path) -> None:
    done: list[tuple[int, int]] = []
    tracked = list(track_clip(short_clip, lambda *counts: done.append(counts)))
    assert done == [(i, i) for i in range(1, SHORT + 1)]
    assert [frame.timestamp for frame, _ in tracked] == pytest.approx([i / 30 for i in range(SHORT)], abs=0.002)
    assert all(tracking is not None and tracking.landmarks.shape == (478, 3) for _, tracking in tracked)


@pytest.mark.slow
def test_frames_without_a_face(empty_clip: Path) -> None:
    assert [tracking for _, tracking in track_clip(empty_clip)] == [None] * 3


def test_a_missing_clip_is_reported() -> None:
    with pytest.raises(CameraError, match=r"there is no file nosuch\.avi"):
        list(track_clip(Path("nosuch.avi")))


def ramp(times: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Rows that rise by 100 a second."""
    at = np.array(times)
    return at, np.tile(100 * at[:, None], (1, 4))


@pytest.mark.parametrize("fps", [10.0, 25.0, 29.97, 480.0])
def test_even_frames_are_kept_as_they_are(fps: float) -> None:
    times, rows = ramp([i / fps for i in range(40)])
    even_fps, even = to_even_rate(times + np.tile([0.0, EVEN_S / 3], 20), rows)
    assert even_fps == pytest.approx(fps, rel=0.01) and np.array_equal(even, rows)


def test_uneven_frames_are_interpolated_over_the_same_time() -> None:
    times = [0.0, 0.04, 0.08, 0.30, 0.34, 0.90, 1.00, 2.43]
    fps, even = to_even_rate(*ramp(times))
    assert (len(even) - 1) / fps == pytest.approx(2.43, abs=1 / fps)
    expected = 100 * np.arange(len(even)) / fps
    assert even[:-1, 3] == pytest.approx(expected[:-1], abs=0.01)
    assert to_even_rate(*ramp([0.0, 0.001, 0.009, 0.010, 0.5]))[0] == MAX_FPS


def test_a_rate_that_no_file_may_state_is_lowered_over_the_same_time() -> None:
    fps, even = to_even_rate(*ramp([i / 4000 for i in range(2001)]))
    assert fps == MAX_FPS and (len(even) - 1) / fps == pytest.approx(0.5, abs=1 / MAX_FPS)
    assert to_even_rate(*ramp([i / 1000 for i in range(100)]))[0] == pytest.approx(1000)


def test_one_frame_is_a_clip() -> None:
    assert len(to_even_rate(*ramp([0.0]))[1]) == 1
