"""Write motion into a DPC file while it comes: a program that is killed loses its last seconds only.

Strategy. The file has a partial name beside its own until it is complete; it is whole at any time. Frames wait for
SETTLE_S, as they may come in any order, and are then resampled to the frame rate of the file. If a later frame has a
higher rate, what was written is read back and written again with that rate.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import interrupted_note, partial_path, report_write_errors, write_target
from conf.errors import RecordingError
from conf.face.formats.dpc import DpcWriter, read_dpc
from conf.output.motion_recorder import MAX_FRAMES, SAME_TIME_S, RecordedFrames, frames_until, resample

SETTLE_S = 2.0  # that a frame may come after a later one
WRITE_INTERVAL_S = 1.0  # of motion, written at once
_ADVICE = "choose another folder"


class MotionFile:
    """Writes the motion of one caller.

    path : of the file when it is complete
    """

    def __init__(self, path: Path) -> None:
        """Create the partial file. Raises RecordingError."""
        with report_write_errors(path, RecordingError, advice=_ADVICE):
            self.path = write_target(path.absolute())
            self._partial = partial_path(self.path)
            self._partial.touch()
        self._waiting: RecordedFrames = {}  # and the last one before the end of what was written
        self._received = 0
        self._fps = 0.0
        self._start = 0.0  # time of the first frame of the file
        self._writer: DpcWriter | None = None
        self._has_failed = False

    @property
    def is_full(self) -> bool:
        """Whether no more frames are recorded."""
        return max(self._received, self._written) >= MAX_FRAMES

    @property
    def _written(self) -> int:
        return self._writer.frames if self._writer else 0

    def add(self, displacements: NDArray[np.float32], pose: NDArray[np.float64], time: float, *, fps: float) -> None:
        """Add the motion of a time in seconds: (n, 3) in FAPU, and the head pose as a (6,) vector.

        Frames may come in any order, up to SETTLE_S late; of two with the same time the first is kept.
        fps : frame rate of the sender; the file has the highest one
        Raises RecordingError if it cannot be written; what was written before is kept.
        """
        end = self._start + (self._written - 1) / self._fps if self._written else -np.inf
        if self.is_full or time in self._waiting or time <= end:
            return
        self._waiting[time] = displacements.copy(), pose.copy()
        self._received += 1
        try:
            with report_write_errors(self.path, RecordingError, advice=_ADVICE):
                if fps > self._fps:
                    self._change_rate(fps)
                settled = max(self._waiting) - SETTLE_S
                if settled - max(end, min(self._waiting)) >= WRITE_INTERVAL_S:
                    self._write_until(settled)
        except RecordingError:
            self._has_failed = True
            raise

    def close(self) -> Path | None:
        """Complete the file and give it its name. Returns its path, None if there are no frames.

        Raises RecordingError. On an interrupt the partial file is kept, and a note of the exception names it.
        """
        try:
            with report_write_errors(self.path, RecordingError, advice=_ADVICE):
                if self._waiting and not self._has_failed:
                    self._write_until(max(self._waiting))
                if not self._written:
                    self._partial.unlink(missing_ok=True)
                    return None
                self._partial.replace(self.path)
        except BaseException as error:
            if self._partial.exists():
                error.add_note(interrupted_note(self.path))
            raise
        return self.path

    def _write_until(self, time: float) -> None:
        """Write the frames up to a time. Raises OSError."""
        if self._writer is None:
            self._start = min(self._waiting)
            self._writer = DpcWriter(self._partial, fps=self._fps)
        count = min(frames_until(time - self._start, self._fps), MAX_FRAMES)
        grid = self._start + np.arange(self._written, count) / self._fps
        if not len(grid):
            return
        self._writer.write(*resample(self._waiting, grid))
        needed = max(time for time in self._waiting if time <= grid[-1] + SAME_TIME_S)
        self._waiting = {time: frame for time, frame in self._waiting.items() if time >= needed}

    def _change_rate(self, fps: float) -> None:
        """Write what was written again, with another frame rate. Raises OSError."""
        before, before_fps, self._fps = self._writer, self._fps, fps
        if before is None:
            return
        clip = read_dpc(self._partial)
        assert clip.poses is not None
        for i, frame in enumerate(zip(clip.displacements, clip.poses, strict=True)):
            self._waiting.setdefault(self._start + i / before_fps, frame)
        again = partial_path(self._partial)
        try:
            self._writer = DpcWriter(again, fps=fps)
            self._write_until(self._start + (before.frames - 1) / before_fps)
            again.replace(self._partial)
            self._writer.path = self._partial
        except BaseException:
            self._writer, self._fps = before, before_fps
            again.unlink(missing_ok=True)
            raise
