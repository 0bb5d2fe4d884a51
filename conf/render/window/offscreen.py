"""A window in memory: an OpenGL context without a display."""

from typing import Any

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import GraphicsError
from conf.render.gpu_object import GpuObject
from conf.render.window import BLACK, Colour
from conf.render.window.input_events import Event

NO_OPENGL = (
    "OpenGL is not available without a display: install a driver with "
    "`sudo apt install libegl1 libgl1 libgl1-mesa-dri` and try again"
)
EGL: dict[str, Any] = {"backend": "egl"}


def create_offscreen_context() -> moderngl.Context:
    """Create an OpenGL 3.3 context through EGL.

    Raises GraphicsError that names the packages to install if EGL or a driver is missing.
    """
    try:
        return moderngl.create_context(require=330, standalone=True, **EGL)
    except Exception as error:  # glcontext raises bare Exception whatever is missing
        raise GraphicsError(NO_OPENGL) from error


def read_pixels(framebuffer: moderngl.Framebuffer, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR, first row on top, of a framebuffer with `size` (W, H) pixels."""
    width, height = size
    rgba = np.frombuffer(framebuffer.read((0, 0, width, height), components=4), np.uint8).reshape(height, width, 4)
    return np.asarray(cv2.cvtColor(rgba[::-1], cv2.COLOR_RGBA2BGR), dtype=np.uint8)


class OffscreenWindow(GpuObject):
    """An implementation of `Window` without input."""

    def __init__(self, width: int, height: int) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be positive, got {width} x {height}")
        self.ctx = create_offscreen_context()
        self.size = (width, height)
        self.pixel_ratio = 1.0
        self.should_close = False
        self.close_on_escape = True
        colour, depth = self.ctx.renderbuffer(self.size, 4), self.ctx.depth_renderbuffer(self.size)
        self.framebuffer = self.ctx.framebuffer(colour, depth)
        self._owned = (self.framebuffer, colour, depth, self.ctx)

    def poll(self) -> list[Event]:
        """Return no events."""
        return []

    def begin(self, colour: Colour = BLACK) -> None:
        """Start a frame: make this window's context current, bind its framebuffer and clear it."""
        self.ctx.__enter__()  # type: ignore[no-untyped-call]
        self.framebuffer.use()
        self.framebuffer.clear(*colour)

    def end(self) -> None:
        """Do nothing: there is no display."""

    def toggle_full_screen(self) -> None:
        """Do nothing: there is no display."""

    def read(self) -> NDArray[np.uint8]:
        """Return the frame as (H, W, 3) uint8 BGR."""
        return read_pixels(self.framebuffer, self.size)
