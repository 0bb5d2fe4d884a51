"""Find the skin of a mesh that a frown or raised brows fold.

Furrows are drawn by the shader of the skin. It is given the position of each vertex on the neutral face, from the
middle between the brows, so that furrows stay on the skin while it moves, whatever its texture.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import control_point_indices
from conf.face.mesh.mesh import Mesh

# The furrows' reach in cm from the middle between the inner brows: to either side, down, up, back. See furrows.glsl.
SIDE, BELOW, ABOVE, BACK = 5.0, 1.6, 4.4, 4.0
_INNER_BROWS = control_point_indices("brow_inner")


def forehead_positions(mesh: Mesh, points: NDArray[np.float64], /) -> NDArray[np.float32]:
    """Return the (R, 3) neutral positions of the render vertices from the middle between the inner brows, cm.

    points : (n, 3) control points, cm
    """
    return np.asarray(mesh.vertices[mesh.render_vertices] - points[_INNER_BROWS].mean(axis=0), np.float32)


def on_forehead(positions: NDArray[np.float32], triangles: NDArray[np.int32], /) -> NDArray[np.bool_]:
    """Return (F,) which triangles furrows may cross. positions : (R, 3) cm; triangles : (F, 3) render vertices"""
    x, y, z = positions.T
    is_near = (np.abs(x) < SIDE) & (y > -BELOW) & (y < ABOVE) & (z > -BACK)
    return np.asarray(is_near[triangles].any(axis=1))
