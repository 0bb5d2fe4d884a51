"""A synthetic face for tests without a tracker: the mean face's control points, with outlines interpolated between."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_LANDMARKS
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.photographed_face import PhotographedFace
from conf.sender.motion.mean_face import MEAN_FACE

LINES = (
    *(contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP, contours.UPPER_OUTER_LIP, contours.LOWER_OUTER_LIP),
    *(contours.BROW_R, contours.BROW_L, contours.NOSE),
)
LIDS = (contours.UPPER_LID_R, contours.LOWER_LID_R, contours.UPPER_LID_L, contours.LOWER_LID_L)
ASPECT = 4 / 3
POSE = HeadPose(np.array([0.05, -0.1, 0.08]), np.array([0.03, -0.05]), float(np.log(0.03)))


def face_points() -> NDArray[np.float64]:
    """Return (D, 3) cm in face axes, rows as PORTRAIT_LANDMARKS: the mean face, its mouth nearly closed."""
    known = {int(landmark): MEAN_FACE[i] for i, landmark in enumerate(CONTROL_POINT_LANDMARKS)}
    known |= {10: np.array([0.0, 8.5, 4.0]), 168: np.array([0.0, 3.0, 5.0]), 4: np.array([0.0, -1.0, 7.5])}
    angles = np.pi / 2 - 2 * np.pi * np.arange(len(contours.OVAL)) / len(contours.OVAL)
    for landmark, angle in zip(contours.OVAL, angles, strict=True):
        point = np.array([7.3 * np.cos(angle), -0.3 + 8.8 * np.sin(angle), 3.5 - 4 * np.cos(angle) ** 2])
        known.setdefault(landmark, point)
    for lid in LIDS:
        outer, middle, inner = (known[lid[k]] for k in (0, 4, 8))
        for k, landmark in enumerate(lid):
            t = k / 8
            bulge = 4 * t * (1 - t) * (middle - (outer + inner) / 2)
            known.setdefault(landmark, outer + t * (inner - outer) + bulge)
    for group in LINES:
        given = [i for i, landmark in enumerate(group) if landmark in known]
        for i in [i for i in range(len(group)) if i not in given]:
            point = np.array([np.interp(i, given, [known[group[k]][axis] for k in given]) for axis in range(3)])
            known[group[i]] = point + np.array([0.0, 0.003 * i, 0.0])
    return np.array([known[int(landmark)] for landmark in contours.PORTRAIT_LANDMARKS])


def face_shape(pose: HeadPose = POSE) -> PhotographedFace:
    """Return a photographed face whose outline is roughly a triangle."""
    points = face_points()
    neutral = points[:CONTROL_POINT_COUNT].copy()
    outline = np.array([(-0.35, -0.5), (0.4, -0.5), (0.35, 0.3), (0.1, 0.4), (-0.2, 0.35)])
    return PhotographedFace(ASPECT, pose, points, neutral, Fapu.measure(neutral).lengths(), outline)
