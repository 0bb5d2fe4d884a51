"""A soft dead band against jitter: small motion around the photographed pose is suppressed.

Tracker and codec leave a jitter of about half a millimetre on a face at rest. If the whole face is that near to its
photographed position, it is moved there: the image is as sharp as the photo and does not flicker. Local motion, such as
parting lips or a closing lid, is kept. Patch descriptors are treated likewise, so that a face at rest shows no patches.
"""

import numpy as np
from numpy.typing import NDArray

VERTEX_DEADBAND_CM = 0.15  # RMS distance of the face from the photo at which 1/e of the motion is suppressed
POINT_CM = 0.05  # motion of a control point of which 1/e is suppressed
MOTION_THRESHOLD_CM = 0.35  # local motion of this size is no jitter
DESCRIPTOR_STEPS = 9.0  # the same for descriptors: about the difference for which a patch is worth sending


def dampen_vertices(
    positions: NDArray[np.float64], photo: NDArray[np.float64], face: NDArray[np.bool_], centimetre: float, /
) -> NDArray[np.float64]:
    """Return positions (V, 2) moved towards the photo's, (V, 2), by the stillness of the face's vertices, (V,) bool.

    centimetre : in the positions' unit
    """
    motion = positions - photo
    distance = np.linalg.norm(motion, axis=1) / centimetre
    stillness = stillness_weight(positions, photo, face, centimetre)
    return np.asarray(positions - motion * (stillness * np.exp(-((distance / MOTION_THRESHOLD_CM) ** 2)))[:, None])


def stillness_weight(
    positions: NDArray[np.float64], photo: NDArray[np.float64], face: NDArray[np.bool_], centimetre: float, /
) -> float:
    """Return 1 if the face's vertices are where they were photographed, falling to 0 far away.

    positions, photo : (V, 2); face : (V,) bool; centimetre : in the positions' unit
    """
    distance = np.linalg.norm((positions - photo)[face], axis=1) / centimetre
    return float(np.exp(-np.mean(np.minimum(distance, MOTION_THRESHOLD_CM) ** 2) / VERTEX_DEADBAND_CM**2))


def dampen_descriptor(
    descriptor: NDArray[np.float64], photo: NDArray[np.float64], stillness: float, /
) -> NDArray[np.float64]:
    """Return a patch region's descriptor (k,) moved towards the photo's, (k,). stillness : from stillness_weight"""
    distance = float(np.linalg.norm(descriptor - photo)) / DESCRIPTOR_STEPS
    return np.asarray(descriptor - (descriptor - photo) * stillness * np.exp(-distance * distance))


def dampen_points(motion: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the motion (n, 3) cm of control points since the photo with jitter suppressed."""
    distance = np.linalg.norm(motion, axis=1, keepdims=True) / POINT_CM
    return np.asarray(motion * (1 - np.exp(-distance * distance)))
