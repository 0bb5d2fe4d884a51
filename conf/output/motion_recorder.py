"""Record motion at the times of its frames; a DPC file has frames that are even in time."""

from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError, RecordingError
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.protocol.motion.jitter_buffer import MAX_INTERPOLATION_S

FPS = 30.0  # of motion that has no frame rate of its own
MAX_FRAMES = 108_000  # an hour, 70 MB of memory
SAME_TIME_S = 1e-6
RecordedFrames = dict[float, tuple[NDArray[np.float32], NDArray[np.float64]]]  # time, s: displacements, head pose
_Number = TypeVar("_Number", np.float32, np.float64)


class MotionRecorder:
    """Keeps frames in the order of their times; stops after MAX_FRAMES."""

    def __init__(self) -> None:
        self._frames: RecordedFrames = {}

    @property
    def is_full(self) -> bool:
        """Whether no more frames are recorded."""
        return len(self._frames) >= MAX_FRAMES

    def add(self, displacements: NDArray[np.float32], pose: NDArray[np.float64], time: float) -> None:
        """Add the motion of a time in seconds: (n, 3) in FAPU, and the head pose as a (6,) vector.

        Frames may come in any order; of two with the same time the first is kept.
        """
        if not self.is_full:
            self._frames.setdefault(time, (displacements.copy(), pose.copy()))

    def finish(self, fps: float = FPS) -> MotionClip | None:
        """Return the recorded clip with `fps` frames a second, or None if nothing was added.

        A frame whose time is a multiple of 1/fps from the first one's is in it unchanged, once. Other frames of the
        clip are interpolated as the receiver does: after a gap the motion belongs to its end.
        """
        if not self._frames:
            return None
        first, last = min(self._frames), max(self._frames)
        count = min(frames_until(last - first, fps), MAX_FRAMES)
        return MotionClip(fps, "fapu", *resample(self._frames, first + np.arange(count) / fps))

    def save(self, path: Path, fps: float = FPS) -> Path | None:
        """Write the clip as a DPC file. Returns the path, or None if nothing was added. Raises RecordingError."""
        clip = self.finish(fps)
        if clip is None:
            return None
        try:
            write_dpc(path, clip)
        except (OSError, FileFormatError) as error:
            raise RecordingError(f"{path} cannot be written ({error}); choose another folder") from error
        return path


def frames_until(seconds: float, fps: float) -> int:
    """Return the number of frames, the first at 0, that are at most `seconds` later."""
    return int(seconds * fps + SAME_TIME_S) + 1


def resample(frames: RecordedFrames, grid: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the displacements (k, n, 3) and poses (k, 6) at the times of a grid, (k,) s, which the frames surround.

    They are interpolated as the receiver does: after a gap the motion belongs to its end.
    """
    times = np.array(sorted(frames))
    before = np.searchsorted(times, grid + SAME_TIME_S, side="right") - 1
    after = np.minimum(before + 1, len(times) - 1)
    begins = np.maximum(times[before], times[after] - MAX_INTERPOLATION_S)
    weights = np.clip((grid - begins) / np.maximum(times[after] - begins, SAME_TIME_S), 0.0, 1.0)
    weights[grid - times[before] < SAME_TIME_S] = 0.0
    ordered = [frames[time] for time in times.tolist()]
    return (
        _interpolate(np.array([displacements for displacements, _ in ordered]), before, after, weights),
        _interpolate(np.array([pose for _, pose in ordered]), before, after, weights),
    )


def _interpolate(
    values: NDArray[_Number], before: NDArray[np.intp], after: NDArray[np.intp], weights: NDArray[np.float64]
) -> NDArray[_Number]:
    """Return values[before] + weights (values[after] - values[before]) along the first axis."""
    alpha = weights.astype(values.dtype).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[before] + alpha * (values[after] - values[before]), values.dtype)
