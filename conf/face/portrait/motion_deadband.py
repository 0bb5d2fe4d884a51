"""A face that is as good as still looks as in the photograph: within the noise of motion nothing moves.

Tracker and codec leave a face that keeps still trembling about its place, by half a millimetre. Where the whole face is
that near to where it was photographed, it is brought there: the picture is as sharp as the photograph and does not
flicker. What moves by itself, lips that part or a lid that falls, is left alone. The same holds for patches: over a
face that is as photographed lies none but for what a feature does by itself.
"""

import numpy as np
from numpy.typing import NDArray

VERTEX_DEADBAND_CM = (
    0.15  # root mean square over the face: so far from the photograph, a third is taken off what it moved
)
POINT_CM = 0.05  # a control point this far from where it was photographed moves a third less
MOTION_THRESHOLD_CM = 0.35  # what moved this far by itself is not noise
OWN_STEPS = 9.0  # the same in the keys of a feature: about as much as a patch is worth sending for


def dampen_vertices(
    places: NDArray[np.float64], photo: NDArray[np.float64], face: NDArray[np.bool_], centimetre: float, /
) -> NDArray[np.float64]:
    """Return places (V, 2) drawn towards the photograph's, (V, 2), as far as the face, (V,), is near to them.

    centimetre : its length in the units of places
    """
    moved = places - photo
    far = np.linalg.norm(moved, axis=1) / centimetre
    still = stillness_weight(places, photo, face, centimetre)
    return np.asarray(places - moved * (still * np.exp(-((far / MOTION_THRESHOLD_CM) ** 2)))[:, None])


def stillness_weight(
    places: NDArray[np.float64], photo: NDArray[np.float64], face: NDArray[np.bool_], centimetre: float, /
) -> float:
    """Return how near the face, (V,), is to where it was photographed: 1 there, 0 far away.

    places, photo : (V, 2); centimetre : its length in their units
    """
    far = np.linalg.norm((places - photo)[face], axis=1) / centimetre
    return float(np.exp(-np.mean(np.minimum(far, MOTION_THRESHOLD_CM) ** 2) / VERTEX_DEADBAND_CM**2))


def dampen_descriptor(keys: NDArray[np.float64], photo: NDArray[np.float64], still: float, /) -> NDArray[np.float64]:
    """Return what a feature does, (k,) steps of its keys, drawn towards what it did in the photograph, (k,).

    still : of the face, as `stillness`
    """
    far = float(np.linalg.norm(keys - photo)) / OWN_STEPS
    return np.asarray(keys - (keys - photo) * still * np.exp(-far * far))


def dampen_points(moved: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return what control points moved since the photograph, (n, 3) cm, without their noise."""
    far = np.linalg.norm(moved, axis=1, keepdims=True) / POINT_CM
    return np.asarray(moved * (1 - np.exp(-far * far)))
