"""One picture on the card, drawn through some of the mesh's triangles."""

import moderngl
import numpy as np
from numpy.typing import NDArray


def load_texture(
    ctx: moderngl.Context, pixels: NDArray[np.uint8], alpha: NDArray[np.uint8] | None = None
) -> moderngl.Texture:
    """Put (H, W, 3) uint8 BGR and (H, W) uint8 alpha on the card, first row first."""
    height, width = pixels.shape[:2]
    rgba = np.empty((height, width, 4), np.uint8)
    rgba[..., :3] = pixels[..., ::-1]
    rgba[..., 3] = 255 if alpha is None else alpha
    texture = ctx.texture((width, height), 4, rgba.tobytes())
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


class TexturedLayer:
    """A texture with its place on the mesh."""

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
        """places : (V, 2) float32, shared by all layers; uvs : (V, 2); shares : (V,) 0 to 1; triangles : (F, 3)."""
        self._texture = texture
        self._rows = ctx.buffer(np.column_stack([uvs, alphas]).astype("f4").tobytes())
        self._indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        content = [(positions, "2f4", "in_place"), (self._rows, "2f4 1f4", "in_uv", "in_share")]
        self._array = ctx.vertex_array(program, content, self._indices, skip_errors=True)

    def draw(self) -> None:
        """Draw with the program's uniforms as they are."""
        self._texture.use(0)
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._rows, self._texture):
            thing.release()
