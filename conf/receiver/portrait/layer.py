"""A texture on the GPU, drawn through some triangles of the mesh."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.gpu_object import GpuObject


def load_texture(
    ctx: moderngl.Context, pixels: NDArray[np.uint8], alpha: NDArray[np.uint8] | None = None
) -> moderngl.Texture:
    """Return a texture of (H, W, 3) uint8 BGR and (H, W) uint8 alpha, first row first."""
    height, width = pixels.shape[:2]
    rgba = np.empty((height, width, 4), np.uint8)
    rgba[..., :3] = pixels[..., ::-1]
    rgba[..., 3] = 255 if alpha is None else alpha
    texture = ctx.texture((width, height), 4, rgba.tobytes())
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


class TexturedLayer(GpuObject):
    """A texture with its coordinates on the mesh."""

    def __init__(
        self,
        ctx: moderngl.Context,
        program: moderngl.Program,
        positions: moderngl.Buffer,
        *,
        uvs: NDArray[np.floating],
        alphas: NDArray[np.floating],
        triangles: NDArray[np.integer],
        texture: moderngl.Texture,
    ) -> None:
        """Take over the texture. positions : (V, 2) float32, shared; uvs : (V, 2); alphas : (V,); triangles : (F, 3)"""
        self._texture = texture
        attributes = ctx.buffer(np.column_stack([uvs, alphas]).astype("f4").tobytes())
        indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        content = [(positions, "2f4", "in_position"), (attributes, "2f4 1f4", "in_uv", "in_alpha")]
        self._array = ctx.vertex_array(program, content, indices, skip_errors=True)
        self._owned = (self._array, indices, attributes, texture)

    def draw(self) -> None:
        """Draw with the program's current uniforms."""
        self._texture.use(0)
        self._array.render(moderngl.TRIANGLES)
