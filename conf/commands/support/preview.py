"""The window of `conf send --preview`: the camera's image with the control points that are sent."""

from collections.abc import Callable

import cv2
import glfw
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.render.gpu_object import GpuObject
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.input_events import KeyPressed
from conf.sender.capture.frame import Frame
from conf.sender.tracking.tracker import TrackedFace

DOT = (90, 230, 90)  # BGR
NEUTRAL_KEY = "n"


class Preview(GpuObject):
    """A window with the frame and the fifty points on it. The key N calls on_neutral."""

    def __init__(self, size: tuple[int, int], *, on_neutral: Callable[[], None]) -> None:
        """Open the window. Raises GraphicsError if that is not possible."""
        self._on_neutral = on_neutral
        self._window = GlfwWindow(*size, "conf: what is sent (N: this is my neutral face)")
        glfw.swap_interval(0)  # drawing must not delay the motion until the next vertical blank
        self._texture = self._window.ctx.texture(size, 4)
        self._source = self._window.ctx.framebuffer(self._texture)
        self._owned = (self._source, self._texture, self._window)

    def show(self, frame: Frame, tracking: TrackedFace | None) -> None:
        """Draw a frame, unless the window has been closed."""
        if self._window.should_close:
            return
        events = self._window.poll()
        self._texture.write(rgba(with_points(frame.pixels, tracking)).tobytes())
        self._window.begin()
        self._window.ctx.copy_framebuffer(self._window.framebuffer, self._source)
        self._window.end()
        if any(isinstance(event, KeyPressed) and event.key == NEUTRAL_KEY for event in events):
            self._on_neutral()


def with_points(pixels: NDArray[np.uint8], tracking: TrackedFace | None) -> NDArray[np.uint8]:
    """Return a copy of an image (H, W, 3) uint8 BGR with the control points drawn on it."""
    image = pixels.copy()
    if tracking is not None:
        radius = max(1, pixels.shape[0] // 240)
        for x, y in tracking.landmarks[CONTROL_POINT_LANDMARKS, :2]:
            cv2.circle(image, (round(float(x)), round(float(y))), radius, DOT, cv2.FILLED, cv2.LINE_AA)
    return image


def rgba(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, bottom row first as in OpenGL."""
    return np.ascontiguousarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGBA)[::-1], dtype=np.uint8)
