"""A window that nobody sees: an OpenGL context without a display, with the interface of the real window."""

from types import TracebackType
from typing import Any

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import GraphicsError
from conf.render.window.input_events import Event

NO_OPENGL = (
    "OpenGL cannot be had without a display: install a driver with "
    "`sudo apt install libegl1 libgl1 libgl1-mesa-dri` and try again"
)

Colour = tuple[float, float, float, float]  # sRGB and cover, 0 to 1
BLACK: Colour = (0.0, 0.0, 0.0, 0.0)
EGL: dict[str, Any] = {"backend": "egl"}


def create_offscreen_context() -> moderngl.Context:
    """Make an OpenGL 3.3 context through EGL.

    Raises GraphicsError that names the packages when there is no EGL or no driver.
    """
    try:
        return moderngl.create_context(require=330, standalone=True, **EGL)
    except Exception as error:  # glcontext raises bare Exception whatever is missing
        raise GraphicsError(NO_OPENGL) from error


def read_pixels(framebuffer: moderngl.Framebuffer, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR, first row on top, of a framebuffer that is `size` (W, H) large."""
    width, height = size
    rgba = np.frombuffer(framebuffer.read((0, 0, width, height), components=4), np.uint8).reshape(height, width, 4)
    return np.asarray(cv2.cvtColor(rgba[::-1], cv2.COLOR_RGBA2BGR), dtype=np.uint8)


class OffscreenWindow:
    """A picture in memory to draw into."""

    def __init__(self, width: int, height: int) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be positive, got {width} x {height}")
        self.ctx = create_offscreen_context()
        self.size = (width, height)
        self.pixel_ratio = 1.0
        self.should_close = False
        self.close_on_escape = True  # as the real window has it: there are no keys here
        self._colour = self.ctx.renderbuffer(self.size, 4)
        self._depth = self.ctx.depth_renderbuffer(self.size)
        self.framebuffer = self.ctx.framebuffer(self._colour, self._depth)

    def poll(self) -> list[Event]:
        """Return no events: nobody sits before it."""
        return []

    def begin(self, colour: Colour = BLACK) -> None:
        """Start a frame: of one colour, and drawn into from now on. Other windows' contexts step back."""
        self.ctx.__enter__()  # type: ignore[no-untyped-call]
        self.framebuffer.use()
        self.framebuffer.clear(*colour)

    def end(self) -> None:
        """Finish the frame. There is nothing to present."""

    def toggle_full_screen(self) -> None:
        """Change nothing: there is no screen to fill."""

    def read(self) -> NDArray[np.uint8]:
        """Return the picture as (H, W, 3) uint8 BGR."""
        return read_pixels(self.framebuffer, self.size)

    def release(self) -> None:
        """Free everything; the window cannot be used any more."""
        for thing in (self.framebuffer, self._colour, self._depth, self.ctx):
            thing.release()

    def __enter__(self) -> "OffscreenWindow":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.release()
