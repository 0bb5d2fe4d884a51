"""The stage: every caller's face in one picture, side by side."""

import math
from collections.abc import Mapping

from conf.face.head import FaceModel
from conf.face.head_pose import NEUTRAL_POSE, HeadPose
from conf.protocol.messages import MotionFrame
from conf.receiver.framing import Framer
from conf.receiver.offscreen import OffscreenWindow
from conf.receiver.renderer import FaceRenderer
from conf.receiver.scene import View
from conf.receiver.window import GlfwWindow

Window = GlfwWindow | OffscreenWindow
Cell = tuple[int, int, int, int]  # x, y of the lower left corner, width, height, in pixels


def grid(count: int, size: tuple[int, int]) -> list[Cell]:
    """Return a cell of the picture for each caller, in rows from the top, as square as the picture allows.

    size : width and height of the picture in pixels
    """
    width, height = size
    columns = min(range(1, count + 1), key=lambda c: abs(math.log(width / c * math.ceil(count / c) / height)))
    rows = math.ceil(count / columns)
    w, h = width // columns, height // rows
    return [(i % columns * w, height - (i // columns + 1) * h, w, h) for i in range(count)]


class Stage:
    """Draws the callers' motion on one face model into a window."""

    def __init__(self, window: Window, face: FaceModel) -> None:
        self._window = window
        self._face = face
        self._renderer = FaceRenderer(window.ctx, face)
        self._framers: dict[int, Framer] = {}

    def draw(self, frames: Mapping[int, MotionFrame | None], view: View, now: float) -> None:
        """Draw one picture: each caller's frame, by the caller's number; None or nobody is the neutral face."""
        self._framers = {caller: self._framers.get(caller, Framer()) for caller in frames}
        actors = list(frames.items()) or [(-1, None)]
        framebuffer = self._window.framebuffer
        for (caller, frame), cell in zip(actors, grid(len(actors), self._window.size), strict=True):
            framebuffer.viewport = cell
            if frame is None:
                vertices, pose = self._face.neutral, NEUTRAL_POSE
            else:
                vertices, pose = self._face.deform(frame.displacements), HeadPose.from_vector(frame.pose)
                pose = self._framers[caller].place(pose, now) if view.centred else pose
            self._renderer.draw(vertices, pose, view, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)

    def release(self) -> None:
        """Free everything on the card."""
        self._renderer.release()
