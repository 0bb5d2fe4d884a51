"""A take: what the face does while it is performed, taken down to be played and exported like any recording."""

import numpy as np
from numpy.typing import NDArray

from conf.animator.motion_player import NamedClip
from conf.face.formats.dpc import MotionClip
from conf.face.head_pose import HeadPose

FPS = 30.0
MOST_SECONDS = 600.0


class MotionRecorder:
    """Moments as they come, at whatever rate the window draws."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._displacements: list[NDArray[np.float32]] = []
        self._poses: list[NDArray[np.float64]] = []

    def add(self, displacements: NDArray[np.float32], pose: HeadPose, now: float) -> None:
        """Take down a moment: (n, 3) FAPU units, and the head's pose. After MOST_SECONDS nothing is added."""
        if self._times and (now <= self._times[-1] or now - self._times[0] > MOST_SECONDS):
            return
        self._times.append(now)
        self._displacements.append(displacements.copy())
        self._poses.append(pose.to_vector())

    def finish(self, name: str) -> NamedClip | None:
        """Return it at an even rate; None if there are not two moments."""
        if len(self._times) < 2:
            return None
        times = np.array(self._times) - self._times[0]
        wanted = np.arange(int(times[-1] * FPS) + 1) / FPS
        after = np.clip(np.searchsorted(times, wanted, side="right"), 1, len(times) - 1)
        share = ((wanted - times[after - 1]) / (times[after] - times[after - 1])).clip(0.0, 1.0)
        frames = _between(np.array(self._displacements), after, share[:, None, None]).astype(np.float32)
        return NamedClip(name, MotionClip(FPS, "fapu", frames, _between(np.array(self._poses), after, share[:, None])))


def _between(values: NDArray[np.floating], after: NDArray[np.intp], share: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(values[after - 1] + share * (values[after] - values[after - 1]), np.float64)
