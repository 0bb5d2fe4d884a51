"""Windows: one on a display and one in memory, with the same interface."""

from typing import Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.window.input_events import Event

Colour = tuple[float, float, float, float]  # sRGB and alpha, 0 to 1
BLACK: Colour = (0.0, 0.0, 0.0, 0.0)


class Window(Protocol):
    """What a program may use of a window, whether it is on a display or in memory.

    size : width and height of the framebuffer in pixels
    should_close : true once the user closed the window; a program may set it
    close_on_escape : whether Escape and Q close the window
    """

    ctx: moderngl.Context
    framebuffer: moderngl.Framebuffer
    size: tuple[int, int]
    should_close: bool
    close_on_escape: bool

    @property
    def pixel_ratio(self) -> float:
        """Pixels per point of the display."""

    def poll(self) -> list[Event]:
        """Return the input events since the last call, oldest first."""

    def begin(self, colour: Colour = BLACK) -> None:
        """Start a frame: make this window's context current, bind its framebuffer and clear it."""

    def end(self) -> None:
        """Present the frame. On a display, wait for the next refresh."""

    def read(self) -> NDArray[np.uint8]:
        """Return the frame as (H, W, 3) uint8 BGR. Call it before `end`."""

    def toggle_full_screen(self) -> None:
        """Fill the monitor, or restore the window's former size and position."""
