"""Shadow map of the key light: the shadow of the chin on the neck and of the nose on the cheek.

The face's depth is rendered from the direction of the key light; the vertex shader compares its depth with that.
Source: Williams, "Casting curved shadows on curved surfaces", 1978.
"""

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh
from conf.render.gpu_object import GpuObject
from conf.render.lighting import STUDIO, Vector
from conf.render.materials import material_of
from conf.render.shader_programs import DrawCall, to_column_major

SIZE = 256  # pixels a side
EXTENT_CM = 18.0  # half of the side of the square, around the face's origin, that the map covers
# The map is redrawn after a rotation, rad, or a movement, cm, of more than this: far less than a shadow's soft edge.
REDRAW_ANGLE = 0.03
REDRAW_DISTANCE_CM = 0.12


def light_matrix(rotation: NDArray[np.float64], key: Vector = STUDIO.key) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from face coordinates, cm, to the clip coordinates of the shadow map.

    rotation : (3, 3) from face axes to image axes
    key : direction towards the light, image axes
    """
    towards = np.array(key) / np.linalg.norm(key)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(towards, right), -towards])
    matrix = np.eye(4)
    matrix[:3, :3] = axes @ rotation / EXTENT_CM
    return matrix


class ShadowMap(GpuObject):
    """Depth of one mesh as the key light sees it; eyes, mouth and clothes cast no shadow."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, vertices: moderngl.Buffer) -> None:
        """vertices : positions and normals of the render vertices, (R, 6) float32"""
        self._ctx = ctx
        self.depth = ctx.depth_texture((SIZE, SIZE))
        self.depth.repeat_x = self.depth.repeat_y = False
        self._drawn: tuple[NDArray[np.float64], NDArray[np.float32]] | None = None
        self._framebuffer = ctx.framebuffer(depth_attachment=self.depth)
        names = [name for name in mesh.groups if material_of(name).casts_shadow]
        casters = np.concatenate([mesh.groups[name] for name in names]) if names else slice(None)
        attributes = [(vertices, "3f4 3x4", "in_position")]
        self._casters = DrawCall(ctx, ("depth_only", "depth_only"), attributes, mesh.render_triangles[casters])
        self._owned = (self._casters, self._framebuffer, self.depth)

    def update(self, light: NDArray[np.float64], points: NDArray[np.float32]) -> NDArray[np.float64]:
        """Redraw the map if the face has moved: that costs an eighth of drawing the face.

        light : (4, 4) of `light_matrix`; points : (n, 3) of the face, cm
        Returns the (4, 4) light matrix with which the map was drawn last.
        """
        if self._drawn is not None:
            drawn_light, drawn_points = self._drawn
            angle = np.abs(light - drawn_light).max() * EXTENT_CM
            distance = np.abs(points - drawn_points).max(initial=0.0)
            if angle < REDRAW_ANGLE and distance < REDRAW_DISTANCE_CM:
                return drawn_light
        self._drawn = light, points.copy()
        self._framebuffer.use()
        self._framebuffer.clear()
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._casters.draw(light=to_column_major(light))
        return light
