"""Shadow map of the key light: the shadow of the chin on the neck and of the nose on the cheek.

The face's depth is rendered from the direction of the key light; the vertex shader compares its depth with that.
Source: Williams, "Casting curved shadows on curved surfaces", 1978.
"""

from functools import cache

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
# The map is redrawn after a rotation, rad, or a movement, cm, of more than this: a third of a centimetre at the edge of
# the head, where the edge of a shadow is two centimetres wide (`SOFT` in face_shadowed.vert.glsl). Lips that talk move
# by a tenth from frame to frame.
REDRAW_ANGLE = 0.03
REDRAW_DISTANCE_CM = 0.3
MAX_MAPS = 10  # of 0.3 MB; one more than participants of a call


def light_matrix(rotation: NDArray[np.float64], key: Vector = STUDIO.key) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from face coordinates, cm, to the clip coordinates of the shadow map.

    rotation : (3, 3) from face axes to image axes
    key : direction towards the light, image axes
    """
    matrix = np.eye(4)
    matrix[:3, :3] = _light_axes(key) @ rotation / EXTENT_CM
    return matrix


@cache
def _light_axes(key: Vector) -> NDArray[np.float64]:
    """Return (3, 3), as rows, the axes of the light's view: to its right, up, and away from the light."""
    towards = np.array(key) / np.linalg.norm(key)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), -towards])


class ShadowMap(GpuObject):
    """Depth of one mesh as the key light sees it; eyes, mouth and clothes cast no shadow.

    Every participant who is drawn with the mesh has a map of its own, so that one who keeps still needs no new one.

    depth : the map that was updated last
    """

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, vertices: moderngl.Buffer) -> None:
        """vertices : positions and normals of the render vertices, (R, 6) float32"""
        self._ctx = ctx
        names = [name for name in mesh.groups if material_of(name).casts_shadow]
        casters = np.concatenate([mesh.groups[name] for name in names]) if names else slice(None)
        attributes = [(vertices, "3f4 3x4", "in_position")]
        self._casters = DrawCall(ctx, ("depth_only", "depth_only"), attributes, mesh.render_triangles[casters])
        self._maps = {0: _DepthMap(ctx)}
        self.depth = self._maps[0].depth

    def update(
        self, light: NDArray[np.float64], points: NDArray[np.float32], *, participant: int = 0
    ) -> NDArray[np.float64]:
        """Redraw a participant's map if the face has moved: that costs an eighth of drawing the face.

        light : (4, 4) of `light_matrix`; points : (n, 3) of the face, cm
        Returns the (4, 4) light matrix with which the map was drawn last.
        """
        found = self._maps.pop(participant, None) or self._oldest_or_new()
        self._maps[participant] = found  # the last used one is the last
        self.depth = found.depth
        if found.drawn is not None:
            drawn_light, drawn_points = found.drawn
            angle = np.abs(light - drawn_light).max() * EXTENT_CM
            distance = np.abs(points - drawn_points).max(initial=0.0)
            if angle < REDRAW_ANGLE and distance < REDRAW_DISTANCE_CM:
                return drawn_light
        found.drawn = light, points.copy()
        found.framebuffer.use()
        found.framebuffer.clear()
        self._ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._casters.draw(light=to_column_major(light))
        return light

    def release(self) -> None:
        for owned in (self._casters, *self._maps.values()):
            owned.release()

    def _oldest_or_new(self) -> "_DepthMap":
        if len(self._maps) < MAX_MAPS:
            return _DepthMap(self._ctx)
        oldest = self._maps.pop(next(iter(self._maps)))
        oldest.drawn = None
        return oldest


class _DepthMap(GpuObject):
    """One map. drawn : light matrix and points with which it was drawn"""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.depth = ctx.depth_texture((SIZE, SIZE))
        self.depth.repeat_x = self.depth.repeat_y = False
        self.framebuffer = ctx.framebuffer(depth_attachment=self.depth)
        self.drawn: tuple[NDArray[np.float64], NDArray[np.float32]] | None = None
        self._owned = (self.framebuffer, self.depth)
