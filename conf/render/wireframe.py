"""Wireframe: the mesh's edges over a dark, solid face."""

import moderngl

from conf.face.mesh.mesh import Mesh
from conf.render.shader_programs import DrawCall

FILL_COLOUR = (0.075, 0.095, 0.125)  # sRGB; hides the edges behind
EDGE_COLOUR = (0.45, 0.78, 0.95)  # sRGB


class WireframeRenderer(DrawCall):
    """Draws all triangles of a mesh as lines."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, vertices: moderngl.Buffer) -> None:
        """vertices : positions and normals of the render vertices, (R, 6) float32"""
        attributes = [(vertices, "3f4 3f4", "in_position", "in_normal")]
        super().__init__(ctx, ("face", "wireframe"), attributes, mesh.render_triangles)
        self._ctx = ctx

    def draw(self, **matrices: bytes) -> None:
        """Draw into the current framebuffer; matrices : clip and rotation."""
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self.program["tint"] = FILL_COLOUR
        self._ctx.polygon_offset = (1.0, 1.0)
        super().draw(**matrices)
        self._ctx.polygon_offset = (0.0, 0.0)
        self.program["tint"] = EDGE_COLOUR
        self._ctx.wireframe = True
        self._array.render(moderngl.TRIANGLES)
        self._ctx.wireframe = False
