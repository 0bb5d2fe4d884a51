"""Close the slits that interpolation leaves between closed lids.

Strategy. Near the corners of an eye the regions of influence of its lids overlap, and the vertices of a coarse mesh do
not lie on the edges that helper points were put on. So the eye is closed and looked at with a grid of rays from the
front: where the eyeball is still visible, the skin above the slit follows its lid by as much more as the slit is high.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.interpolation import smoothstep
from conf.face.mesh.raycast import cast_front_rays

# In cm, 6.4 between the pupils.
_STEP = 0.03  # between rays
_SIDE, _HEIGHT = 0.3, 0.8  # of the grid beyond the corners of the eye, and above and below its lids
_MAX_DEPTH = 1.0  # behind the corners: what is visible deeper than this is no skin
_OVERLAP = 0.03  # by which the lids overlap where there was a slit
_REACH = 0.6  # above a slit, within which skin is moved
_MAX_SLIT = 0.4  # a higher one is no inaccuracy
_SPREAD = 3, 2.0  # columns by which a correction is widened, and standard deviation of its smoothing
_PASSES = 3
# A sculpted blink on the left, FAPU units: the main displacements of action unit 45. The lid stops at contact.
_BLINK = {
    "eyelid_upper": (-7, -1384, -16),
    "eye_outer_corner": (23, -58, -22),
    "eye_inner_corner": (2, 12, -1),
    "eye_upper_outer_lid": (5, -170, 21),
}


def seal_lids(face: FaceModel, /) -> FaceModel:
    """Return the face with an operator that closes its eyes over their whole width."""
    if face.rig is None:
        return face
    closing = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    for name, displacement in _BLINK.items():
        for side, sign in (("l", 1), ("r", -1)):
            closing[CONTROL_POINT_INDEX[f"{name}_{side}"]] = np.multiply(displacement, (sign, 1, 1))
    for eye in face.rig.eyes:
        for _ in range(_PASSES if len(eye.vertices) else 0):
            sealed = _seal_eye(face, closing, eye.pupil)
            if sealed is face:
                break
            face = sealed
    return face


def _seal_eye(face: FaceModel, closing: NDArray[np.float32], pupil: int) -> FaceModel:
    """Return the face after one pass for the eye with a pupil; the face itself if no slit is left."""
    side = next(name for name, index in CONTROL_POINT_INDEX.items() if index == pupil)[-1]
    names = ("eye_outer_corner", "eye_inner_corner", "eyelid_upper", "eyelid_lower")
    rows = [CONTROL_POINT_INDEX[f"{name}_{side}"] for name in names]
    outer, inner, upper, lower = face.control_points[rows]
    vertices = face.deform(closing).astype(np.float64)
    xs = np.arange(min(outer[0], inner[0]) - _SIDE, max(outer[0], inner[0]) + _SIDE, _STEP)
    low, high = min(outer[1], inner[1], lower[1]) - _HEIGHT, max(outer[1], inner[1], upper[1]) + _HEIGHT
    ys = np.arange(low, high, _STEP)
    is_open = _visible(face, vertices, xs, ys, depth=min(outer[2], inner[2]) - _MAX_DEPTH)
    slit = is_open.sum(axis=0) * _STEP
    slit[slit > _MAX_SLIT] = 0.0
    if not slit.any():
        return face
    bottom = np.where(slit > 0, ys[is_open.argmax(axis=0)], np.nan)
    known = np.flatnonzero(slit > 0)
    bottom = np.interp(xs, xs[known], bottom[known])
    slit = maximum_filter1d(np.where(slit > 0, slit + _OVERLAP, 0.0), 2 * _SPREAD[0] + 1)
    slit = gaussian_filter1d(slit, _SPREAD[1])
    above = vertices[:, 1] - np.interp(vertices[:, 0], xs, bottom + slit / 2)
    weight = smoothstep(1 - above / _REACH) * (above > 0) * np.interp(vertices[:, 0], xs, slit, left=0.0, right=0.0)
    weight *= vertices[:, 2] > min(outer[2], inner[2]) - _MAX_DEPTH
    assert face.rig is not None
    weight[face.rig.rigid] = 0.0
    travel = float(upper[1] - lower[1])
    operator = face.operator.copy()
    operator[:, rows[2]] += (weight / max(travel, _STEP)).astype(np.float32)
    return replace(face, operator=operator)


def _visible(
    face: FaceModel, vertices: NDArray[np.float64], xs: NDArray[np.float64], ys: NDArray[np.float64], *, depth: float
) -> NDArray[np.bool_]:
    """Return (ys, xs) where an eyeball, or nothing in front of a depth, is visible."""
    assert face.rig is not None
    is_ball = np.zeros(len(vertices), np.bool_)
    for eye in face.rig.eyes:
        is_ball[eye.vertices] = True
    corners = vertices[face.mesh.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = (high[:, 0] > xs[0]) & (low[:, 0] < xs[-1]) & (high[:, 1] > ys[0]) & (low[:, 1] < ys[-1])
    triangles = face.mesh.triangles[near & (high[:, 2] > depth)]
    visible = np.empty((len(ys), len(xs)), np.bool_)
    for column, x in enumerate(xs):  # a column of rays at a time meets few triangles
        hits = cast_front_rays(np.stack([np.full(len(ys), x), ys], axis=1), vertices, triangles)
        visible[:, column] = ~(hits.points[:, 2] > depth) | is_ball[triangles[hits.triangles, 0]]  # nan is a miss
    return visible
