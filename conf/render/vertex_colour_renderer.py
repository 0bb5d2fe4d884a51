"""Draw a face with a colour at each vertex instead of its texture."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.neck import NeckBend
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.winding import orient_outwards
from conf.render.camera import ViewState, clip_matrix, view_rotation
from conf.render.render_target import RenderTarget
from conf.render.shader_programs import load_program, set_matrix, to_column_major
from conf.render.vertex_normals import VertexNormals

HIDDEN_GROUPS = ("hair", "brows", "lashes")  # what would hide the skin


class VertexColourRenderer:
    """One mesh with colours of its own."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh) -> None:
        mesh = orient_outwards(mesh)
        shown = np.ones(len(mesh.triangles), np.bool_)
        for name in HIDDEN_GROUPS:
            shown[mesh.groups.get(name, [])] = False
        self._ctx = ctx
        self._mesh = mesh
        self._neck = NeckBend(mesh)
        self._surface = VertexNormals(mesh.triangles, mesh.render_vertices)
        self._program = load_program(ctx, "vertex_colour", "vertex_colour")
        self._moving = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        self._colours = ctx.buffer(reserve=len(mesh.render_vertices) * 12)
        triangles = np.ascontiguousarray(mesh.render_triangles[shown], np.int32)
        self._indices = ctx.buffer(triangles.tobytes())
        layout = [(self._moving, "3f4 3f4", "in_position", "in_normal"), (self._colours, "3f4", "in_colour")]
        self._array = ctx.vertex_array(self._program, layout, self._indices)

    def colour(self, colours: NDArray[np.float32]) -> None:
        """Take the colours of the vertices: (V, 3) sRGB, 0 to 1."""
        self._colours.write(np.ascontiguousarray(colours[self._mesh.render_vertices], np.float32))

    def draw(self, vertices: NDArray[np.float32], pose: HeadPose, view: ViewState, canvas: RenderTarget) -> None:
        """Draw (V, 3) vertices, face axes, cm, into a canvas."""
        self._moving.write(self._surface.interleaved(self._neck.apply(vertices, pose)))
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        width, height = canvas.size
        set_matrix(self._program, "clip", to_column_major(clip_matrix(pose, view, aspect=width / height)))
        set_matrix(self._program, "turn", to_column_major(view_rotation(pose, view)))
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._colours, self._moving, self._program):
            thing.release()
