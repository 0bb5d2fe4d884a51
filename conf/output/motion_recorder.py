"""Keep a caller's motion as it is shown, and write it as a DPC file."""

from pathlib import Path

import numpy as np

from conf.errors import FileFormatError, RecordingError
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.protocol.messages import MotionFrame

FPS = 30.0
MAX_FRAMES = 108_000  # an hour: 70 MB of memory


class MotionRecorder:
    """Takes what is shown as often as FPS asks for, until it is closed or an hour is full."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._frames: list[MotionFrame] = []
        self._began: float | None = None

    def add(self, frame: MotionFrame, now: float) -> None:
        """Take the motion that is shown at `now`."""
        self._began = now if self._began is None else self._began
        due = min(int((now - self._began) * FPS) + 1, MAX_FRAMES)
        self._frames += [frame] * (due - len(self._frames))

    def close(self) -> Path | None:
        """Write the file. Returns its path, None if nothing was shown. Raises RecordingError."""
        if not self._frames:
            return None
        motion = MotionClip(
            fps=FPS,
            units="fapu",
            displacements=np.array([frame.displacements for frame in self._frames], np.float32),
            poses=np.array([frame.pose for frame in self._frames]),
        )
        try:
            write_dpc(self.path, motion)
        except (OSError, FileFormatError) as error:
            raise RecordingError(f"{self.path} cannot be written ({error}); choose another folder") from error
        return self.path
