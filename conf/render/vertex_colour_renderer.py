"""Draw a face with one colour per vertex instead of its texture."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.neck import NeckBend
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.winding import orient_outwards
from conf.render.camera import ViewState, clip_matrix, view_rotation
from conf.render.gpu_object import GpuObject
from conf.render.render_target import RenderTarget
from conf.render.shader_programs import DrawCall, to_column_major
from conf.render.vertex_normals import VertexNormals

HIDDEN_GROUPS = ("hair", "brows", "lashes")  # not drawn: they would cover the skin


class VertexColourRenderer(GpuObject):
    """Draws one mesh with given vertex colours."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh) -> None:
        mesh = orient_outwards(mesh)
        is_drawn = np.ones(len(mesh.triangles), np.bool_)
        for name in HIDDEN_GROUPS:
            is_drawn[mesh.groups.get(name, [])] = False
        self._ctx = ctx
        self._render_vertices = mesh.render_vertices
        self._neck = NeckBend(mesh)
        self._normals = VertexNormals(mesh.triangles, mesh.render_vertices)
        self._vertices = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        self._colours = ctx.buffer(reserve=len(mesh.render_vertices) * 12)
        attributes = [(self._vertices, "3f4 3f4", "in_position", "in_normal"), (self._colours, "3f4", "in_colour")]
        triangles = mesh.render_triangles[is_drawn]
        self._draw_call = DrawCall(ctx, ("vertex_colour", "vertex_colour"), attributes, triangles)
        self._owned = (self._draw_call, self._colours, self._vertices)

    def set_colours(self, colours: NDArray[np.float32]) -> None:
        """Set the colours of the vertices: (V, 3) sRGB, 0 to 1."""
        self._colours.write(np.ascontiguousarray(colours[self._render_vertices], np.float32))

    def draw(self, vertices: NDArray[np.float32], pose: HeadPose, view: ViewState, target: RenderTarget) -> None:
        """Draw (V, 3) vertices, face axes, cm, into a render target that was begun."""
        self._vertices.write(self._normals.interleaved(self._neck.apply(vertices, pose)))
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        width, height = target.size
        self._draw_call.draw(
            clip=to_column_major(clip_matrix(pose, view, aspect=width / height)),
            rotation=to_column_major(view_rotation(pose, view)),
        )
