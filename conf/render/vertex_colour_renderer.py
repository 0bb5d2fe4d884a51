"""Draw a face with one colour per vertex instead of its texture."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh
from conf.render.materials import TRANSLUCENT
from conf.render.shader_programs import DrawCall

HIDDEN_GROUPS = ("hair", "brows", "lashes", TRANSLUCENT)  # not drawn: they would cover the skin


class VertexColourRenderer(DrawCall):
    """Draws one mesh with given vertex colours."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, vertices: moderngl.Buffer) -> None:
        """vertices : positions and normals of the render vertices, (R, 6) float32"""
        is_drawn = np.ones(len(mesh.triangles), np.bool_)
        for name in HIDDEN_GROUPS:
            is_drawn[mesh.groups.get(name, [])] = False
        self._ctx = ctx
        self._render_vertices = mesh.render_vertices
        self._colours = ctx.buffer(reserve=len(mesh.render_vertices) * 12)
        attributes = [(vertices, "3f4 3f4", "in_position", "in_normal"), (self._colours, "3f4", "in_colour")]
        super().__init__(ctx, ("vertex_colour", "vertex_colour"), attributes, mesh.render_triangles[is_drawn])
        self._owned = (*self._owned, self._colours)

    def set_colours(self, colours: NDArray[np.float32]) -> None:
        """Set the colours of the vertices: (V, 3) sRGB, 0 to 1."""
        self._colours.write(np.ascontiguousarray(colours[self._render_vertices], np.float32))

    def draw(self, **matrices: bytes) -> None:
        """Draw into the current framebuffer; matrices : clip and rotation."""
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        super().draw(**matrices)
