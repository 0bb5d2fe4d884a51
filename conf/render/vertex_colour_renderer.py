"""Draw a face with a colour at each vertex instead of its texture."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.neck import Neck
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.render.camera import View, clip_matrix, rotation
from conf.render.face_renderer import facing_outwards
from conf.render.render_target import Canvas
from conf.render.shader_programs import columns, program, set_matrix
from conf.render.vertex_normals import Surface

BARE = ("hair", "brows", "lashes")  # what would hide the skin


class TintedFace:
    """One mesh with colours of its own."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh) -> None:
        mesh = facing_outwards(mesh)
        shown = np.ones(len(mesh.triangles), np.bool_)
        for name in BARE:
            shown[mesh.groups.get(name, [])] = False
        self._ctx = ctx
        self._mesh = mesh
        self._neck = Neck(mesh)
        self._surface = Surface(mesh.triangles, mesh.render_vertices)
        self._program = program(ctx, "vertex_colour", "vertex_colour")
        self._moving = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        self._colours = ctx.buffer(reserve=len(mesh.render_vertices) * 12)
        triangles = np.ascontiguousarray(mesh.render_triangles[shown], np.int32)
        self._indices = ctx.buffer(triangles.tobytes())
        layout = [(self._moving, "3f4 3f4", "in_position", "in_normal"), (self._colours, "3f4", "in_colour")]
        self._array = ctx.vertex_array(self._program, layout, self._indices)

    def colour(self, colours: NDArray[np.float32]) -> None:
        """Take the colours of the vertices: (V, 3) sRGB, 0 to 1."""
        self._colours.write(np.ascontiguousarray(colours[self._mesh.render_vertices], np.float32))

    def draw(self, vertices: NDArray[np.float32], pose: HeadPose, view: View, canvas: Canvas) -> None:
        """Draw (V, 3) vertices, face axes, cm, into a canvas."""
        self._moving.write(self._surface.rows(self._neck.bend(vertices, pose)))
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        width, height = canvas.size
        set_matrix(self._program, "clip", columns(clip_matrix(pose, view, aspect=width / height)))
        set_matrix(self._program, "turn", columns(rotation(pose, view)))
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._colours, self._moving, self._program):
            thing.release()
