"""The mesh's edges over a dark, solid face."""

import moderngl
import numpy as np

from conf.face.mesh.mesh import Mesh
from conf.render.shader_programs import load_program, set_matrix

SOLID = (0.075, 0.095, 0.125)  # sRGB: hides what lies behind
EDGES = (0.45, 0.78, 0.95)


class WireframeRenderer:
    """Draws all triangles of a mesh as lines."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, moving: moderngl.Buffer) -> None:
        """moving : positions and normals of the render vertices, (R, 6) float32"""
        self._ctx = ctx
        self._program = load_program(ctx, "face", "wireframe")
        self._indices = ctx.buffer(np.ascontiguousarray(mesh.render_triangles, dtype=np.int32).tobytes())
        layout = [(moving, "3f4 3f4", "in_position", "in_normal")]
        self._array = ctx.vertex_array(self._program, layout, self._indices)

    def draw(self, clip: bytes, turn: bytes) -> None:
        """Draw into the current framebuffer: the two matrices as `columns` gives them."""
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        set_matrix(self._program, "clip", clip)
        set_matrix(self._program, "turn", turn)
        self._program["ink"] = SOLID
        self._ctx.polygon_offset = (1.0, 1.0)
        self._array.render(moderngl.TRIANGLES)
        self._ctx.polygon_offset = (0.0, 0.0)
        self._program["ink"] = EDGES
        self._ctx.wireframe = True
        self._array.render(moderngl.TRIANGLES)
        self._ctx.wireframe = False

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._program):
            thing.release()
