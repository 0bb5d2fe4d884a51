"""`conf send --preview`: what the camera sees and what is sent of it, in a small window of one's own."""

import cv2
import glfw
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.input_events import KeyPressed
from conf.sender.capture.video import Frame
from conf.sender.tracking.tracker import TrackedFace

DOT = (90, 230, 90)  # BGR
NEUTRAL_KEY = "n"


class Preview:
    """A window with the frame and the fifty points on it. N takes the face as it is for the neutral pose."""

    def __init__(self, size: tuple[int, int]) -> None:
        """Raises GraphicsError where no window can be opened."""
        self.neutral_wanted = False
        self._size = size
        self._window = GlfwWindow(*size, "conf: what is sent (N: this is my neutral face)")
        glfw.swap_interval(0)  # the picture must not hold the motion back
        self._texture = self._window.ctx.texture(size, 4)
        self._source = self._window.ctx.framebuffer(self._texture)

    def show(self, frame: Frame, tracking: TrackedFace | None) -> None:
        """Draw a frame; once the window is closed nothing is drawn any more."""
        if self._window.should_close:
            return
        for event in self._window.poll():
            self.neutral_wanted |= isinstance(event, KeyPressed) and event.key == NEUTRAL_KEY
        self._texture.write(rgba(with_points(frame.pixels, tracking)).tobytes())
        self._window.begin()
        self._window.ctx.copy_framebuffer(self._window.framebuffer, self._source)
        self._window.end()

    def close(self) -> None:
        """Close the window."""
        for thing in (self._source, self._texture, self._window):
            thing.release()


def with_points(pixels: NDArray[np.uint8], tracking: TrackedFace | None) -> NDArray[np.uint8]:
    """Return a copy of a picture (H, W, 3) uint8 BGR with the control points on it."""
    picture = pixels.copy()
    if tracking is not None:
        radius = max(1, pixels.shape[0] // 240)
        for x, y in tracking.landmarks[CONTROL_POINT_LANDMARKS, :2]:
            cv2.circle(picture, (round(float(x)), round(float(y))), radius, DOT, cv2.FILLED, cv2.LINE_AA)
    return picture


def rgba(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, the first row at the bottom as OpenGL has it."""
    return np.ascontiguousarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGBA)[::-1], dtype=np.uint8)
