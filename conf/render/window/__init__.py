"""Windows: one on a display and one in memory, with the same interface."""

import ctypes
from collections.abc import Callable

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.gpu_object import GpuObject
from conf.render.window.input_events import Event

Colour = tuple[float, float, float, float]  # sRGB and alpha, 0 to 1
BLACK: Colour = (0.0, 0.0, 0.0, 0.0)


def read_pixels(framebuffer: moderngl.Framebuffer, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR, first row on top, of a framebuffer with `size` (W, H) pixels."""
    width, height = size
    rgba = np.frombuffer(framebuffer.read((0, 0, width, height), components=4), np.uint8).reshape(height, width, 4)
    return np.asarray(cv2.cvtColor(rgba[::-1], cv2.COLOR_RGBA2BGR), dtype=np.uint8)


def _load_finish(ctx: moderngl.Context) -> Callable[[], object]:
    """Return OpenGL's glFinish, during which other threads run; moderngl's holds Python's lock until all is drawn."""
    loader = getattr(ctx.mglo, "_context", None)
    address = loader.load_opengl_function("glFinish") if loader else 0
    return ctypes.CFUNCTYPE(None)(address) if address else ctx.finish


class Window(GpuObject):
    """What a program may use of a window, whether it is on a display or in memory, where it has no input.

    size : width and height of the framebuffer in pixels
    should_close : true once the user closed the window; a program may set it
    close_on_escape : whether Escape and Q close the window
    clipboard : the text of the desktop's clipboard; a program may set it
    visible : whether the window is on the display; a program may set it
    """

    ctx: moderngl.Context
    framebuffer: moderngl.Framebuffer
    should_close: bool = False
    close_on_escape = True
    clipboard: str = ""
    visible: bool = True

    def __init__(self, width: int, height: int) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be positive, got {width} x {height}")
        self.size = (width, height)
        self._finish: Callable[[], object] | None = None  # loaded when it is first needed

    @property
    def pixel_ratio(self) -> float:
        """Pixels per point of the display."""
        return 1.0

    def poll(self) -> list[Event]:
        """Return the input events since the last call, oldest first."""
        return []

    def begin(self, colour: Colour = BLACK) -> None:
        """Start a frame: make this window's context current, bind its framebuffer and clear it."""
        self.framebuffer.use()
        self.framebuffer.clear(*colour)

    def end(self) -> None:
        """Present the frame. On a display, wait for the next refresh."""

    def finish(self) -> None:
        """Wait until all is drawn. Other threads run meanwhile: where the CPU draws, sound would be interrupted."""
        self._finish = self._finish or _load_finish(self.ctx)
        self._finish()

    def read(self) -> NDArray[np.uint8]:
        """Return the frame as (H, W, 3) uint8 BGR. Call it before `end`."""
        self.finish()
        return read_pixels(self.framebuffer, self.size)

    def toggle_full_screen(self) -> None:
        """Fill the monitor, or restore the window's former size and position."""
