"""Remove the head pose from landmarks: the expression is left."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.head_pose import HeadPose
from conf.face.similarity import fit_similarity
from conf.sender.tracking.canonical_face import CanonicalFace

FLIP = np.array([1.0, -1.0, -1.0])  # from the tracker's axes (y down, z away) to the face's (y up, z to the viewer)


def remove_head_pose(
    landmarks: NDArray[np.floating], canonical: CanonicalFace, size: tuple[int, int], /
) -> tuple[NDArray[np.float64], HeadPose]:
    """Align landmarks with the canonical face.

    landmarks : (478, 3) px, x right, y down, z away from the camera
    size : width and height of the image, px
    Returns the landmarks (478, 3), cm in face axes, and the head pose.
    """
    points = np.asarray(landmarks, dtype=np.float64) * FLIP
    fit = fit_similarity(canonical.vertices[canonical.rigid], points[canonical.rigid], canonical.weights)
    aligned = (points - fit.translation) @ fit.rotation / fit.scale
    width, height = size
    position = (fit.translation[:2] - np.array([width, -height]) / 2) / height
    rotation = Rotation.from_matrix(fit.rotation).as_rotvec()
    return aligned, HeadPose(rotation, position, float(np.log(fit.scale / height)))
