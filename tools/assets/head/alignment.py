"""Put the head where the tracker's canonical face is, so that the head pose alone lays one over the other."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

# Landmarks of MediaPipe's canonical face model (cm, x to the subject's left, y up, z to the viewer), midline and left;
# the model is symmetric. Source: geometry metadata of face_landmarker.task.
CANONICAL = {
    "chin_bottom": (0.000, -9.403, 4.264),
    "inner_lip_upper_mid": (0.000, -3.994, 5.219),
    "inner_lip_lower_mid": (0.000, -4.542, 5.405),
    "inner_lip_corner_l": (2.153, -4.276, 4.038),
    "inner_lip_upper_l": (1.024, -3.990, 4.927),
    "inner_lip_lower_l": (1.099, -4.459, 5.121),
    "chin_boss": (0.000, -7.942, 5.181),
    "eyelid_upper_l": (3.177, 2.964, 3.877),
    "eyelid_lower_l": (3.177, 2.294, 3.776),
    "eye_outer_corner_l": (4.446, 2.664, 3.173),
    "eye_inner_corner_l": (1.856, 2.585, 3.758),
    "outer_lip_upper_mid": (0.000, -3.406, 5.980),
    "outer_lip_lower_mid": (0.000, -5.365, 5.535),
    "outer_lip_corner_l": (2.456, -4.343, 4.284),
    "outer_lip_upper_l": (1.432, -3.501, 5.496),
    "outer_lip_lower_l": (1.325, -5.107, 5.205),
    "cupids_bow_l": (0.711, -3.329, 5.877),
    "nostril_border_l": (1.786, -0.978, 4.850),
    "nose_bottom_edge_l": (1.406, -1.714, 5.241),
}


def align(points: dict[str, NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rotation (3, 3) and translation (3,) that bring the named points nearest to the canonical ones.

    Only pitch and a shift in the plane of symmetry are sought: both faces are symmetric.
    """
    names = [name for name in CANONICAL if name in points]
    ours = np.array([points[name] for name in names])
    theirs = np.array([CANONICAL[name] for name in names])
    flip = np.array([-1.0, 1.0, 1.0])
    ours, theirs = np.vstack([ours, ours * flip]), np.vstack([theirs, theirs * flip])
    rotation = Rotation.align_vectors(theirs - theirs.mean(axis=0), ours - ours.mean(axis=0))[0].as_matrix()
    shift = theirs.mean(axis=0) - rotation @ ours.mean(axis=0)
    return rotation, shift * [0.0, 1.0, 1.0]
