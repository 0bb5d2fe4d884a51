"""From mouse to mesh: the surface point under a pixel, the control point near it."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_clip_rays
from conf.render.materials import material_of
from conf.render.preparation.transparency import with_transparent_parts

MAX_DEPTH_ERROR_CM = 1.5  # if the ray's hit lies farther than this from a mirrored position, the nearest vertex is used


class Picker:
    """Casts rays at one mesh in its neutral pose. Rays pass through hair and eyelashes."""

    def __init__(self, mesh: Mesh) -> None:
        mesh = with_transparent_parts(mesh)
        solid = np.ones(len(mesh.triangles), np.bool_)
        for name, triangles in mesh.groups.items():
            if material_of(name).blended:
                solid[triangles] = False
        self._vertices = mesh.vertices
        self._triangles = mesh.triangles[solid if solid.any() else slice(None)]
        self._tree = KDTree(mesh.vertices[np.unique(self._triangles)])
        self.centre_x = float((mesh.vertices[:, 0].min() + mesh.vertices[:, 0].max()) / 2)

    def pick(self, ndc: NDArray[np.float64], clip: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the (3,) surface point visible at (2,) normalised device coordinates, None beside the face."""
        hit = cast_clip_rays(ndc[None], clip, self._vertices, self._triangles)[0]
        return hit if np.isfinite(hit).all() else None

    def project_to_surface(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (3,) frontmost surface point at the position's x and y, or the nearest vertex if that is far."""
        extent = float(np.abs(self._vertices).max()) + 1.0
        frontal = np.diag([1 / extent, 1 / extent, -1 / extent, 1.0])
        hit = cast_clip_rays(position[None, :2] / extent, frontal, self._vertices, self._triangles)[0]
        if np.isfinite(hit).all() and np.linalg.norm(hit - position) < MAX_DEPTH_ERROR_CM:
            return np.asarray(hit)
        nearest: NDArray[np.float64] = self._tree.data[self._tree.query(position)[1]]
        return nearest


def nearest_point(x: float, y: float, points: NDArray[np.float64], *, radius: float) -> int | None:
    """Return the index of the one of (n, 2) points that is nearest to a pixel, None if none is within the radius.

    Points that are nan are ignored.
    """
    distance = np.hypot(points[:, 0] - x, points[:, 1] - y)
    distance = np.where(np.isfinite(distance), distance, np.inf)
    nearest = int(distance.argmin())
    return nearest if distance[nearest] <= radius else None
