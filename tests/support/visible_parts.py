"""What of a face is visible from the front, by casting rays."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP_EDGE, UPPER_LIP_EDGE
from conf.face.deformation.face_model import FaceModel
from conf.face.mesh.raycast import cast_front_rays

STEP = 0.02  # between rays of a column, cm


def visible_groups(face: FaceModel, vertices: NDArray[np.float32], points_2d: NDArray[np.float64]) -> NDArray[np.str_]:
    """Return the group hit at each position (L, 2) on deformed vertices (V, 3); "skin" for others, "" for a miss."""
    names = np.full(len(face.mesh.triangles), "skin", dtype="<U12")
    for group, triangles in face.mesh.groups.items():
        if group != "default":
            names[triangles] = group
    hits = cast_front_rays(points_2d, vertices.astype(np.float64), face.mesh.triangles).triangles
    return np.where(hits < 0, "", names[hits])


def max_lid_gap(face: FaceModel, vertices: NDArray[np.float32], side: str) -> float:
    """Return the greatest height, cm, over which anything but skin is visible in a column over the whole eye."""
    names = ("eye_outer_corner", "eye_inner_corner", "eyelid_upper", "eyelid_lower")
    lids = face.control_points[[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in names], :2]
    (left, bottom), (right, top) = lids.min(axis=0), lids.max(axis=0)
    x, y = np.meshgrid(np.arange(left - 0.2, right + 0.2, 0.1), np.arange(bottom - 0.8, top + 0.3, STEP))
    hit = visible_groups(face, vertices, np.stack([x.ravel(), y.ravel()], axis=1)).reshape(x.shape)
    return float((hit != "skin").sum(axis=0).max() * STEP)


def between_lips(face: FaceModel, vertices: NDArray[np.float32], points: NDArray[np.float32]) -> NDArray[np.str_]:
    """Return the groups visible between displaced inner lip points (n, 3), away from their edges."""
    upper, lower = points[UPPER_LIP_EDGE][1:-1].astype(np.float64), points[LOWER_LIP_EDGE][1:-1].astype(np.float64)
    t = np.linspace(0.15, 0.85, 15)[:, None, None]
    return visible_groups(face, vertices, (upper * t + lower * (1 - t)).reshape(-1, 3)[:, :2])
