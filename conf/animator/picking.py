"""From the mouse to the mesh: which place of the face lies under a pixel, which mark is near it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_clip_rays
from conf.render.camera import project
from conf.render.materials import material_of

SNAP_CM = 1.5  # a mirrored place farther from the mesh's front than this goes to the nearest vertex instead


@dataclass(frozen=True)
class Rect:
    """A rectangle of the window: pixels from the upper left corner, y down."""

    x: float
    y: float
    width: float
    height: float

    def contains(self, x: float, y: float) -> bool:
        """Tell whether a place lies inside."""
        return self.x <= x < self.x + self.width and self.y <= y < self.y + self.height

    def to_ndc(self, x: float, y: float) -> NDArray[np.float64]:
        """Return (2,) a place in OpenGL's coordinates of the rectangle, -1 to 1, y up."""
        return np.array([2 * (x - self.x) / self.width - 1, 1 - 2 * (y - self.y) / self.height])

    def to_pixels(self, places: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n, 2) pixels of the window for (n, 3) places of the face under a (4, 4) clip matrix."""
        pixels: NDArray[np.float64] = project(places, clip, (self.width, self.height)) + np.array([self.x, self.y])
        return pixels


class Picker:
    """Casts rays at one mesh at rest; hair and lashes let them through."""

    def __init__(self, mesh: Mesh) -> None:
        solid = np.ones(len(mesh.triangles), np.bool_)
        for name, triangles in mesh.groups.items():
            if material_of(name).blended:
                solid[triangles] = False
        self._vertices = mesh.vertices
        self._triangles = mesh.triangles[solid if solid.any() else slice(None)]
        self._tree = KDTree(mesh.vertices[np.unique(self._triangles)])
        self.middle = float((mesh.vertices[:, 0].min() + mesh.vertices[:, 0].max()) / 2)

    def pick(self, place: NDArray[np.float64], clip: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the (3,) point of the mesh seen at a place (2,), -1 to 1, y up; None beside the face."""
        hit = cast_clip_rays(place[None], clip, self._vertices, self._triangles)[0]
        return hit if np.isfinite(hit).all() else None

    def project_to_surface(self, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (3,) point of the mesh for a place near it: straight behind or before it, or the nearest."""
        reach = float(np.abs(self._vertices).max()) + 1.0
        straight = np.diag([1 / reach, 1 / reach, -1 / reach, 1.0])
        hit = cast_clip_rays(place[None, :2] / reach, straight, self._vertices, self._triangles)[0]
        if np.isfinite(hit).all() and np.linalg.norm(hit - place) < SNAP_CM:
            return np.asarray(hit)
        nearest: NDArray[np.float64] = self._tree.data[self._tree.query(place)[1]]
        return nearest


def nearest_point(x: float, y: float, marks: NDArray[np.float64], *, reach: float) -> int | None:
    """Return the index of the mark, (n, 2) pixels, nearest to a place, None if none is within reach."""
    distance = np.hypot(marks[:, 0] - x, marks[:, 1] - y)
    distance = np.where(np.isfinite(distance), distance, np.inf)
    nearest = int(distance.argmin())
    return nearest if distance[nearest] <= reach else None
