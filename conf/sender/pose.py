"""Take the head's pose out of the landmarks: what is left is the expression.

Source: Horn, Hilden, Negahdaripour 1988; Umeyama 1991 (the similarity with the least weighted squared error).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.head_pose import HeadPose
from conf.sender.canonical_face import CanonicalFace

FLIP = np.array([1.0, -1.0, -1.0])  # from the tracker's axes (y down, z away) to the face's (y up, z to the viewer)


@dataclass(frozen=True)
class Similarity:
    """A turn, a size and a shift: target = scale * rotation @ source + translation.

    rotation : (3, 3) float64, proper
    scale : float
    translation : (3,) float64
    """

    rotation: NDArray[np.float64]
    scale: float
    translation: NDArray[np.float64]


def fit_similarity(
    source: NDArray[np.float64], target: NDArray[np.float64], weights: NDArray[np.float64], /
) -> Similarity:
    """Find the similarity that carries points onto points with the least weighted squared error.

    source, target : (K, 3), not all on one line
    weights : (K,), not negative
    """
    share = weights / weights.sum()
    source_middle, target_middle = share @ source, share @ target
    a, b = source - source_middle, target - target_middle
    u, stretch, vt = np.linalg.svd(b.T @ (share[:, None] * a))
    keep = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])  # a mirror image is not a turn
    rotation = (u * keep) @ vt
    scale = float(stretch @ keep / (share @ np.sum(a * a, axis=1)))
    return Similarity(rotation, scale, target_middle - scale * rotation @ source_middle)


def remove_head_pose(
    landmarks: NDArray[np.floating], canonical: CanonicalFace, size: tuple[int, int], /
) -> tuple[NDArray[np.float64], HeadPose]:
    """Turn landmarks to face the viewer at the canonical face's place and size.

    landmarks : (478, 3) px, x right, y down, z away from the camera
    size : width and height of the picture, px
    Returns the landmarks (478, 3) in cm in face axes, and where the head is.
    """
    points = np.asarray(landmarks, dtype=np.float64) * FLIP
    fit = fit_similarity(canonical.vertices[canonical.rigid], points[canonical.rigid], canonical.weights)
    aligned = (points - fit.translation) @ fit.rotation / fit.scale
    width, height = size
    place = (fit.translation[:2] - np.array([width, -height]) / 2) / height
    return aligned, HeadPose(Rotation.from_matrix(fit.rotation).as_rotvec(), place, float(np.log(fit.scale / height)))
