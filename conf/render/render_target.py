"""What the face is drawn on before it goes into the framebuffer: background and depth, then smooth edges."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.shader_programs import load_program

# sRGB, from the top of the picture to its bottom: a quiet studio wall, lighter behind the shoulders.
BACKDROP_GRADIENT = np.array([(34, 38, 46), (48, 54, 64), (58, 62, 70), (40, 42, 48)], dtype=np.float64)
BACKDROPS = {
    "wall": BACKDROP_GRADIENT,
    "warm": np.array([(70, 58, 50), (104, 88, 74), (120, 102, 86), (74, 62, 54)], dtype=np.float64),
    "light": np.array([(196, 202, 210), (222, 226, 231), (230, 233, 237), (204, 208, 214)], dtype=np.float64),
}
SOLID_COLOURS = {
    "white": (255, 255, 255),
    "black": (0, 0, 0),
    "green": (0, 177, 64),
    "blue": (0, 71, 187),
}  # to be keyed
# The first pass composes and marks edges with depth 0, the second smooths what is marked. Without a GPU a pixel that
# fails the depth test costs nothing, while both sides of a branch are always paid for.
PASSES = ("compose", "antialias")
DEPTH_FUNCS = ("1", ">")  # always; where something nearer was marked
DEPTH_BIAS = 0.0035  # of the depth range, 4 mm: what lies so little under the surface still counts as seen
VIGNETTE = 0.38  # how much darker the corners are


def paint_background(size: tuple[int, int], background: str = "wall") -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, first row at the bottom: a soft gradient, dithered so that no bands show.

    size : width and height in pixels
    background : a name from WALLS, or from PLAIN for one colour all over
    """
    width, height = size
    if background in SOLID_COLOURS:
        return np.tile(np.array([*SOLID_COLOURS[background], 255], np.uint8), (height, width, 1))
    wall = BACKDROPS[background]
    y = np.linspace(1.0, 0.0, height)[:, None]
    x = np.linspace(-1.0, 1.0, width)[None, :]
    stops = np.linspace(0.0, 1.0, len(wall))
    column = np.stack([np.interp(y[:, 0], stops, wall[:, c]) for c in range(3)], axis=1)
    light = 1.0 - VIGNETTE * np.clip(x**2 * 0.55 + (2 * y - 1.0) ** 2 * 0.45, 0.0, 1.0) ** 1.2
    noise = np.random.default_rng(1).random((height, width, 1))
    pixels = np.full((height, width, 4), 255, np.uint8)
    pixels[..., :3] = np.floor(column[:, None, :] * light[..., None] + noise)
    return pixels


class RenderTarget:
    """A picture of its own size that is shown with its edges smoothed."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], background: str = "wall") -> None:
        self.size = size
        self.background = background
        self._ctx = ctx
        self._picture = ctx.texture(size, 4)
        self._picture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._picture.repeat_x = self._picture.repeat_y = False
        self.depth = ctx.depth_texture(size)
        self.depth.compare_func = ""
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._background = ctx.texture(size, 4, paint_background(size, background).tobytes())
        self._wall = ctx.framebuffer(self._background)
        self._framebuffer = ctx.framebuffer(self._picture, self.depth)
        self._passes = [load_program(ctx, "fullscreen", name) for name in PASSES]
        for step in self._passes:
            step["canvas"] = 0
            step["pixel"] = 1 / size[0], 1 / size[1]
        self._triangles = [ctx.vertex_array(step, []) for step in self._passes]

    def begin(self) -> None:
        """Hang the background and draw before it from now on."""
        self._framebuffer.use()
        self._framebuffer.clear()
        self._ctx.copy_framebuffer(self._framebuffer, self._wall)
        self._framebuffer.use()

    def resolve(self, framebuffer: moderngl.Framebuffer) -> None:
        """Put the picture, its edges smoothed, into a framebuffer's viewport, which must be as large."""
        framebuffer.use()
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._picture.use(0)
        for triangle, depth_func in zip(self._triangles, DEPTH_FUNCS, strict=True):
            self._ctx.depth_func = depth_func
            triangle.render(moderngl.TRIANGLES, vertices=3)
        self._ctx.depth_func = "<"

    def visible(self, places: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of (k, 3) places nothing hides that was drawn under a (4, 4) clip matrix; none outside is seen."""
        homogeneous = places @ clip[:, :3].T + clip[:, 3]
        at = homogeneous[:, :3] / homogeneous[:, 3:] * 0.5 + 0.5
        width, height = self.size
        depths = np.frombuffer(self.depth.read(), np.float32).reshape(height, width)
        column, row = (at[:, :2] * self.size).astype(int).T
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        surface = depths[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
        return np.asarray(inside & (at[:, 2] <= surface + DEPTH_BIAS))

    def release(self) -> None:
        """Free everything on the card."""
        for triangle, step in zip(self._triangles, self._passes, strict=True):
            triangle.release()
            step.release()
        for thing in (self._framebuffer, self._wall, self.depth, self._background, self._picture):
            thing.release()
