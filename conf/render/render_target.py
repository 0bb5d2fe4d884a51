"""Offscreen render target of a face: background, colour and depth, with the edges anti-aliased when it is resolved."""

from functools import lru_cache

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.drawn_area import BANDS, Rectangle, complement
from conf.render.gpu_object import GpuObject
from conf.render.shader_programs import load_program

# Vertical gradients, sRGB, from top to bottom. The first is a dark wall that is lighter behind the shoulders.
BACKDROPS = {
    "wall": np.array([(34, 38, 46), (48, 54, 64), (58, 62, 70), (40, 42, 48)], dtype=np.float64),
    "warm": np.array([(70, 58, 50), (104, 88, 74), (120, 102, 86), (74, 62, 54)], dtype=np.float64),
    "light": np.array([(196, 202, 210), (222, 226, 231), (230, 233, 237), (204, 208, 214)], dtype=np.float64),
}
# sRGB; green and blue for chroma keying.
SOLID_COLOURS = {"white": (255, 255, 255), "black": (0, 0, 0), "green": (0, 177, 64), "blue": (0, 71, 187)}
VIGNETTE = 0.38  # how much darker the corners are
# The first pass copies the image and writes depth 0 at edges, the second smooths where the depth is 0. A software
# renderer pays nothing for a pixel that fails the depth test, but always pays for both sides of a branch.
PASSES = {"edges": "1", "antialias": ">"}  # shader -> depth test: always; where a smaller depth was written
PAINTED = 4  # backgrounds kept: painting one takes as long as several frames
CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)], np.float32)  # of the two triangles of a rectangle
MAX_RECTANGLES = 3 * BANDS + 1  # those beside all bands and the one above them
DEPTH_BIAS = 0.0035  # of the depth range, 4 mm: a point at most this far below the surface counts as visible


@lru_cache(maxsize=PAINTED)
def paint_background(size: tuple[int, int], background: str = "wall") -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, first row at the bottom: a gradient with a vignette, dithered against banding.

    size : width and height in pixels
    background : a key of BACKDROPS, or of SOLID_COLOURS for a uniform colour
    """
    width, height = size
    if background in SOLID_COLOURS:
        return np.tile(np.array([*SOLID_COLOURS[background], 255], np.uint8), (height, width, 1))
    gradient = BACKDROPS[background]
    y = np.linspace(1.0, 0.0, height)[:, None]
    x = np.linspace(-1.0, 1.0, width)[None, :]
    stops = np.linspace(0.0, 1.0, len(gradient))
    column = np.stack([np.interp(y[:, 0], stops, gradient[:, c]) for c in range(3)], axis=1)
    light = 1.0 - VIGNETTE * np.clip(x**2 * 0.55 + (2 * y - 1.0) ** 2 * 0.45, 0.0, 1.0) ** 1.2
    noise = np.random.default_rng(1).random((height, width, 1))
    pixels = np.full((height, width, 4), 255, np.uint8)
    pixels[..., :3] = np.floor(column[:, None, :] * light[..., None] + noise)
    pixels.flags.writeable = False
    return pixels


def sample_background(size: tuple[int, int], full_size: tuple[int, int], background: str) -> NDArray[np.uint8]:
    """Return `paint_background` of the full size with fewer pixels, and with its dither, in a fraction of the time."""
    if size == full_size:
        return paint_background(size, background)
    rows, columns = (np.arange(n) * full // n for n, full in zip(size[::-1], full_size[::-1], strict=True))
    return np.ascontiguousarray(paint_background(full_size, background)[rows[:, None], columns])


class RenderTarget(GpuObject):
    """An image with depth that is copied, anti-aliased, to a framebuffer."""

    def __init__(
        self,
        ctx: moderngl.Context,
        size: tuple[int, int],
        background: str = "wall",
        *,
        full_size: tuple[int, int] | None = None,
    ) -> None:
        """size : of the image in pixels; full_size : of the viewport that it is enlarged to, None for no enlargement"""
        self.size = size
        self.background = background
        self._ctx = ctx
        self._image = _texture(ctx, size, moderngl.NEAREST)
        self.depth = ctx.depth_texture(size)
        self.depth.compare_func = ""
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        backdrop = ctx.texture(size, 4, sample_background(size, full_size or size, background).tobytes())
        backdrop.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._backdrop = ctx.framebuffer(backdrop)
        self._framebuffer = ctx.framebuffer(self._image, self.depth)
        self._depth_only = ctx.framebuffer(depth_attachment=self.depth)
        programs = [load_program(ctx, "rectangles", name) for name in ("copy", *PASSES)]
        for program in programs:
            program["image"] = 0
            if "pixel" in program:
                program["pixel"] = 1 / size[0], 1 / size[1]
        self._corners = ctx.buffer(reserve=MAX_RECTANGLES * CORNERS.nbytes)
        content = [(self._corners, "2f4", "in_position")]
        copy, *passes = [ctx.vertex_array(program, content) for program in programs]
        self._copying = copy, "<"
        self._smoothing = list(zip(passes, PASSES.values(), strict=True))
        self._backdrop_image = backdrop
        self._resolved: moderngl.Texture | None = None
        framebuffers = (self._framebuffer, self._depth_only, self._backdrop)
        self._owned = (copy, *passes, *programs, self._corners, *framebuffers)
        self._owned += (self.depth, backdrop, self._image)
        if full_size not in (None, size):
            self._resolved, depth = _texture(ctx, size, moderngl.LINEAR), ctx.depth_renderbuffer(size)
            self._enlarged = ctx.framebuffer(self._resolved, depth)
            assert full_size is not None
            self._backdrop_image = ctx.texture(full_size, 4, paint_background(full_size, background).tobytes())
            self._backdrop_image.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._owned = (self._enlarged, self._resolved, depth, self._backdrop_image, *self._owned)

    def begin(self) -> None:
        """Copy the background, clear the depth, and make this the target of the following draw calls."""
        self._depth_only.use()
        self._depth_only.clear()
        self._ctx.copy_framebuffer(self._framebuffer, self._backdrop)
        self._framebuffer.use()

    def resolve(self, framebuffer: moderngl.Framebuffer, bands: list[Rectangle] | None = None) -> None:
        """Copy the image, anti-aliased, into a framebuffer's viewport, which must have the size of the target.

        bands : parts of the image in which something was drawn, sorted upwards; None for all of it
        """
        bands = [(0, 0, *self.size)] if bands is None else bands
        if self._resolved is None:
            self._compose(framebuffer, bands)
            return
        self._smooth(self._enlarged, [_grown(band, self.size) for band in bands])
        full_size = framebuffer.viewport[2:]
        enlarged = _scaled(bands, self.size, full_size)
        framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        self._resolved.use(0)
        self._render(enlarged, full_size, self._copying)
        self._backdrop_image.use(0)
        self._render(complement(enlarged, full_size), full_size, self._copying)

    def _compose(self, framebuffer: moderngl.Framebuffer, bands: list[Rectangle]) -> None:
        """Draw the background beside the bands and the anti-aliased image inside."""
        framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        self._backdrop_image.use(0)
        self._render(complement(bands, self.size), self.size, self._copying)
        self._smooth(framebuffer, bands)

    def _smooth(self, framebuffer: moderngl.Framebuffer, bands: list[Rectangle]) -> None:
        """Copy bands of the image, anti-aliased."""
        framebuffer.use()
        self._image.use(0)
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._render(bands, self.size, *self._smoothing)
        self._ctx.depth_func = "<"

    def _render(self, parts: list[Rectangle], size: tuple[int, int], *passes: tuple[moderngl.VertexArray, str]) -> None:
        """Draw passes, each with its depth test, into parts of the viewport. size : of the viewport in pixels"""
        rectangles = np.array(parts, np.float32).reshape(-1, 1, 4)
        positions = (rectangles[..., :2] + CORNERS * rectangles[..., 2:]) / np.array(size, np.float32)
        self._corners.orphan()
        self._corners.write(positions)
        for triangles, depth_func in passes if parts else ():
            self._ctx.depth_func = depth_func
            triangles.render(moderngl.TRIANGLES, vertices=len(CORNERS) * len(parts))

    def visible(self, points: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (k,) bool: which of (k, 3) points are inside the image and not hidden by what was drawn.

        clip : (4, 4) clip matrix with which it was drawn
        """
        homogeneous = points @ clip[:, :3].T + clip[:, 3]
        position = homogeneous[:, :3] / homogeneous[:, 3:] * 0.5 + 0.5
        width, height = self.size
        depths = np.frombuffer(self.depth.read(), np.float32).reshape(height, width)
        column, row = (position[:, :2] * self.size).astype(int).T
        is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        surface = depths[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
        return np.asarray(is_inside & (position[:, 2] <= surface + DEPTH_BIAS))


def _grown(band: Rectangle, size: tuple[int, int]) -> Rectangle:
    """Return a band with the pixels around it that enlarging blends in."""
    left, bottom, width, height = band
    right, top = min(left + width + 1, size[0]), min(bottom + height + 1, size[1])
    return max(left - 1, 0), max(bottom - 1, 0), right - max(left - 1, 0), top - max(bottom - 1, 0)


def _scaled(bands: list[Rectangle], size: tuple[int, int], full_size: tuple[int, int]) -> list[Rectangle]:
    """Return the bands of an image of `size` in one of the full size; neighbours still touch."""
    x, y = full_size[0] / size[0], full_size[1] / size[1]
    scaled = []
    for left, bottom, width, height in bands:
        low, high = (round(left * x), round(bottom * y)), (round((left + width) * x), round((bottom + height) * y))
        scaled.append((*low, high[0] - low[0], high[1] - low[1]))
    return scaled


def _texture(ctx: moderngl.Context, size: tuple[int, int], texture_filter: int) -> moderngl.Texture:
    """Return an empty RGBA texture, clamped to its edge."""
    texture = ctx.texture(size, 4)
    texture.filter = (texture_filter, texture_filter)
    texture.repeat_x = texture.repeat_y = False
    return texture
