"""A window in memory: an OpenGL context without a display."""

from typing import Any

import moderngl

from conf.errors import GraphicsError
from conf.render.window import BLACK, Colour, Window

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


class OffscreenWindow(Window):
    """A window whose framebuffer is in memory."""

    def __init__(self, width: int, height: int) -> None:
        super().__init__(width, height)
        self.ctx = create_offscreen_context()
        colour, depth = self.ctx.renderbuffer(self.size, 4), self.ctx.depth_renderbuffer(self.size)
        self.framebuffer = self.ctx.framebuffer(colour, depth)
        self._owned = (self.framebuffer, colour, depth, self.ctx)

    def begin(self, colour: Colour = BLACK) -> None:
        self.ctx.__enter__()  # type: ignore[no-untyped-call]
        super().begin(colour)
