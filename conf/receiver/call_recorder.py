"""Record the motion that callers send: every frame that arrives, at its time on the sender's clock."""

from collections.abc import Iterable
from pathlib import Path

from conf.output.image_writer import next_free_path
from conf.output.motion_recorder import MotionRecorder
from conf.protocol.motion.inbound import ReceivedFrame


class CallRecorder:
    """One recording for each caller, by session: their clocks are their own."""

    def __init__(self) -> None:
        self._recorders: dict[int, MotionRecorder] = {}
        self._fps: dict[int, float] = {}

    @property
    def is_full(self) -> bool:
        """Whether one of the recordings has reached its limit of an hour."""
        return any(recorder.is_full for recorder in self._recorders.values())

    def add(self, session: int, frames: Iterable[ReceivedFrame]) -> None:
        """Add the frames that have arrived from a caller, in any order."""
        for received in frames:
            recorder = self._recorders.setdefault(session, MotionRecorder())
            recorder.add(received.frame.displacements, received.frame.pose, received.frame.timestamp)
            self._fps[session] = max(self._fps.get(session, 0.0), received.fps)  # the finest grid holds every frame

    def save(self, folder: Path) -> list[Path]:
        """Write a DPC file for each caller of whom frames arrived. Returns their paths. Raises RecordingError."""
        saved = []
        for session, recorder in self._recorders.items():
            if path := recorder.save(next_free_path(folder, "conf", ".dpc"), self._fps[session]):
                saved.append(path)
        return saved
