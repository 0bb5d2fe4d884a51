"""What lies between the face and the framebuffer: the face's own picture, the background, smooth edges."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.receiver.programs import program

# sRGB, from the top of the picture to its bottom: a quiet studio wall, lighter behind the shoulders.
WALL = np.array([(34, 38, 46), (48, 54, 64), (58, 62, 70), (40, 42, 48)], dtype=np.float64)
VIGNETTE = 0.38  # how much darker the corners are


def paint_wall(size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, first row at the bottom: a soft gradient, dithered so that no bands show.

    size : width and height in pixels
    """
    width, height = size
    y = np.linspace(1.0, 0.0, height)[:, None]
    x = np.linspace(-1.0, 1.0, width)[None, :]
    stops = np.linspace(0.0, 1.0, len(WALL))
    column = np.stack([np.interp(y[:, 0], stops, WALL[:, c]) for c in range(3)], axis=1)
    light = 1.0 - VIGNETTE * np.clip(x**2 * 0.55 + (2 * y - 1.0) ** 2 * 0.45, 0.0, 1.0) ** 1.2
    noise = np.random.default_rng(1).random((height, width, 1))
    pixels = np.full((height, width, 4), 255, np.uint8)
    pixels[..., :3] = np.floor(column[:, None, :] * light[..., None] + noise)
    return pixels


class Canvas:
    """A picture of the face alone, that is put over the background with its edges smoothed."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self._ctx = ctx
        self._scene = ctx.texture(size, 4)
        self._scene.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.depth = ctx.depth_texture(size)
        self.depth.compare_func = ""
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._background = ctx.texture(size, 4, paint_wall(size).tobytes())
        self._background.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._framebuffer = ctx.framebuffer(self._scene, self.depth)
        self._program = program(ctx, "screen", "screen")
        self._program["scene"] = 0
        self._program["background"] = 1
        self._triangle = ctx.vertex_array(self._program, [])

    def begin(self) -> None:
        """Clear the face's picture and draw into it from now on."""
        self._framebuffer.use()
        self._framebuffer.clear(0.0, 0.0, 0.0, 0.0)

    def show(self, framebuffer: moderngl.Framebuffer, corner: tuple[int, int]) -> None:
        """Put the face over the background into a framebuffer; corner is the lower left one, in pixels."""
        framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        self._scene.use(0)
        self._background.use(1)
        self._program["origin"] = corner
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (
            self._triangle,
            self._program,
            self._framebuffer,
            self.depth,
            self._background,
            self._scene,
        ):
            thing.release()
