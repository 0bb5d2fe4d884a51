"""Record motion as it is shown, at an even frame rate, and write it as a DPC file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError, RecordingError
from conf.face.formats.dpc import MotionClip, write_dpc

FPS = 30.0
MAX_FRAMES = 108_000  # an hour, 70 MB of memory


class MotionRecorder:
    """Resamples motion, which is shown at uneven times, to FPS by linear interpolation; stops after MAX_FRAMES."""

    def __init__(self) -> None:
        self._displacements: list[NDArray[np.float32]] = []
        self._poses: list[NDArray[np.float64]] = []
        self._began = self._last_time = 0.0
        self._last: tuple[NDArray[np.float32], NDArray[np.float64]] | None = None

    def add(self, displacements: NDArray[np.float32], pose: NDArray[np.float64], now: float) -> None:
        """Add the motion shown at `now`, seconds: (n, 3) in FAPU, and the head pose as a (6,) vector."""
        if self._last is None:
            self._began = self._last_time = now
            self._last = displacements, pose
        last_displacements, last_pose = self._last
        due = min(int((now - self._began) * FPS) + 1, MAX_FRAMES)
        for i in range(len(self._poses), due):
            elapsed = self._began + i / FPS - self._last_time
            alpha = min(max(elapsed / (now - self._last_time), 0.0), 1.0) if now > self._last_time else 1.0
            between = last_displacements + alpha * (displacements - last_displacements)
            self._displacements.append(between.astype(np.float32))
            self._poses.append(last_pose + alpha * (pose - last_pose))
        if now > self._last_time:
            self._last, self._last_time = (displacements.copy(), pose.copy()), now

    def finish(self) -> MotionClip | None:
        """Return the recorded clip, or None if nothing was added."""
        if not self._poses:
            return None
        return MotionClip(FPS, "fapu", np.array(self._displacements), np.array(self._poses))

    def save(self, path: Path) -> Path | None:
        """Write the clip as a DPC file. Returns the path, or None if nothing was added. Raises RecordingError."""
        clip = self.finish()
        if clip is None:
            return None
        try:
            write_dpc(path, clip)
        except (OSError, FileFormatError) as error:
            raise RecordingError(f"{path} cannot be written ({error}); choose another folder") from error
        return path
