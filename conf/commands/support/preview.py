"""The window of `conf send --preview`: the camera's image with the control points that are sent.

A microphone that is muted is shown in it.
"""

from collections.abc import Callable

import cv2
import glfw
import numpy as np
from numpy.typing import NDArray

from conf.commands.support.sound import MuteSwitch
from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.render.gpu_object import GpuObject
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.input_events import KeyPressed
from conf.sender.capture.frame import Frame
from conf.sender.tracking.tracker import TrackedFace

DOT = (90, 230, 90)  # BGR
NEUTRAL_KEY = "n"
MUTE_KEY = "m"
TITLE = "conf: what is sent (N: this is my neutral face, M: mute)"
MUTED = "muted"
TEXT_COLOR, TEXT_EDGE = (60, 170, 255), (0, 0, 0)  # BGR
TEXT_HEIGHT = 0.06  # of a capital, as a fraction of the image's height


class Preview(GpuObject):
    """A window with the frame and the fifty points on it. The key N calls on_neutral, M switches the microphone."""

    def __init__(self, size: tuple[int, int], mute: MuteSwitch, *, on_neutral: Callable[[], None]) -> None:
        """Open the window. Raises GraphicsError if that is not possible."""
        self._mute = mute
        self._on_key = {NEUTRAL_KEY: on_neutral, MUTE_KEY: mute.toggle}
        self._window = GlfwWindow(*size, TITLE)
        glfw.swap_interval(0)  # drawing must not delay the motion until the next vertical blank
        self._texture = self._window.ctx.texture(size, 4)
        self._source = self._window.ctx.framebuffer(self._texture)
        self._owned = (self._source, self._texture, self._window)

    def show(self, frame: Frame, tracking: TrackedFace | None) -> None:
        """Draw a frame, unless the window has been closed."""
        if self._window.should_close:
            return
        events = self._window.poll()
        for event in events:
            if isinstance(event, KeyPressed) and event.key in self._on_key:
                self._on_key[event.key]()
        image = with_points(frame.pixels, tracking)
        self._texture.write(rgba(with_text(image, MUTED) if self._mute.is_muted else image).tobytes())
        self._window.begin()
        self._window.ctx.copy_framebuffer(self._window.framebuffer, self._source)
        self._window.end()


def with_points(pixels: NDArray[np.uint8], tracking: TrackedFace | None) -> NDArray[np.uint8]:
    """Return a copy of an image (H, W, 3) uint8 BGR with the control points drawn on it."""
    image = pixels.copy()
    if tracking is not None:
        radius = max(1, pixels.shape[0] // 240)
        for x, y in tracking.landmarks[CONTROL_POINT_LANDMARKS, :2]:
            cv2.circle(image, (round(float(x)), round(float(y))), radius, DOT, cv2.FILLED, cv2.LINE_AA)
    return image


def with_text(pixels: NDArray[np.uint8], text: str) -> NDArray[np.uint8]:
    """Return a copy of an image (H, W, 3) uint8 BGR with a short text in its lower left corner."""
    image, font = pixels.copy(), cv2.FONT_HERSHEY_SIMPLEX
    height = round(TEXT_HEIGHT * pixels.shape[0])
    width = max(1, height // 8)
    scale = cv2.getFontScaleFromHeight(font, height, width)
    for color, edge in (TEXT_EDGE, 2 * width), (TEXT_COLOR, 0):
        cv2.putText(image, text, (height, pixels.shape[0] - height), font, scale, color, width + edge, cv2.LINE_AA)
    return image


def rgba(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, bottom row first as in OpenGL."""
    return np.ascontiguousarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGBA)[::-1], dtype=np.uint8)
