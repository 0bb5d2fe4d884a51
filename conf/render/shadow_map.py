"""The shadow of the key light: of the chin on the neck, of the nose on the cheek.

The face's depth is drawn as the lamp sees it; the skin shader asks that picture what the lamp reaches.
Source: Williams, "Casting curved shadows on curved surfaces", 1978.
"""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh
from conf.render.lighting import STUDIO, Vector
from conf.render.materials import material_of
from conf.render.shader_programs import load_program, set_matrix, to_column_major

SIZE = 256  # pixels of the lamp's picture
KEY = np.array(STUDIO.key)
EXTENT_CM = 18.0  # the lamp's picture shows this far around the face's origin
REDRAW_ANGLE = 0.02  # radians, and
REDRAW_DISTANCE_CM = 0.06  # how far the face may have moved since: far less than its shadows' edges are wide


def light_matrix(turn: NDArray[np.float64], key: Vector = STUDIO.key) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from face coordinates (cm) to the clip coordinates of the lamp's picture.

    turn : (3, 3) rotation from face axes to picture axes
    key : towards the lamp, picture axes
    """
    towards = np.array(key) / np.linalg.norm(key)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(towards, right), -towards])
    matrix = np.eye(4)
    matrix[:3, :3] = axes @ turn / EXTENT_CM
    return matrix


class ShadowMap:
    """The lamp's picture of one mesh: what casts a shadow is everything but eyes and the mouth's inside."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, moving: moderngl.Buffer) -> None:
        """moving : positions and normals of the render vertices, (R, 6) float32"""
        self._ctx = ctx
        self.depth = ctx.depth_texture((SIZE, SIZE))
        self.depth.repeat_x = self.depth.repeat_y = False
        self._taken: tuple[NDArray[np.float64], NDArray[np.float32]] | None = None
        self._framebuffer = ctx.framebuffer(depth_attachment=self.depth)
        self._program = load_program(ctx, "depth_only", "depth_only")
        names = [name for name in mesh.groups if material_of(name).casts_shadow]
        chosen = np.concatenate([mesh.groups[name] for name in names]) if names else slice(None)
        triangles = mesh.render_triangles[chosen]
        self._indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        self._array = ctx.vertex_array(self._program, [(moving, "3f4 3x4", "in_position")], self._indices)

    def update(self, lamp: NDArray[np.float64], places: NDArray[np.float32]) -> NDArray[np.float64]:
        """Take a new picture if the face has turned or moved since the last one: it costs an eighth of the drawing.

        lamp : (4, 4) of `lamp_matrix`; places : (n, 3) points of the face, cm
        Returns the (4, 4) matrix by which the picture was taken.
        """
        if self._taken is not None:
            matrix, then = self._taken
            turned, moved = np.abs(lamp - matrix).max() * EXTENT_CM, np.abs(places - then).max(initial=0.0)
            if turned < REDRAW_ANGLE and moved < REDRAW_DISTANCE_CM:
                return matrix
        self.draw(to_column_major(lamp))
        self._taken = lamp, places.copy()
        return lamp

    def draw(self, lamp: bytes) -> None:
        """Take the lamp's picture: the matrix of `lamp_matrix` as `columns` gives it."""
        self._framebuffer.use()
        self._framebuffer.clear()
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        set_matrix(self._program, "light", lamp)
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._program, self._framebuffer, self.depth):
            thing.release()
