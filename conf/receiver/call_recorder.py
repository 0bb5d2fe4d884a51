"""Record the motion that callers send: every frame that arrives, at its time on the sender's clock."""

from collections.abc import Iterable
from pathlib import Path

from conf.errors import RecordingError
from conf.output.image_writer import next_free_path
from conf.output.motion_file import MotionFile
from conf.protocol.motion.inbound import ReceivedFrame


class CallRecorder:
    """One DPC file for each caller, by session, as their clocks are their own; written while the frames arrive."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: dict[int, MotionFile] = {}

    @property
    def is_full(self) -> bool:
        """Whether one of the recordings has reached its limit of an hour."""
        return any(file.is_full for file in self._files.values())

    def add(self, session: int, frames: Iterable[ReceivedFrame]) -> None:
        """Add the frames that have arrived from a caller, in any order. Raises RecordingError."""
        for received in frames:
            if session not in self._files:
                self._files[session] = MotionFile(next_free_path(self._folder, "conf", ".dpc"))
            frame = received.frame
            self._files[session].add(frame.displacements, frame.pose, frame.timestamp, fps=received.fps)

    def close(self) -> list[Path]:
        """Complete the files. Returns the paths of those with frames. Raises RecordingError, after closing all."""
        saved: list[Path] = []
        errors: list[RecordingError] = []
        for file in self._files.values():
            try:
                path = file.close()
            except RecordingError as error:
                errors.append(error)
                continue
            if path is not None:
                saved.append(path)
        if errors:
            raise errors[0]
        return saved
