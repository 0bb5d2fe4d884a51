"""A face that is as good as still looks as in the photograph: within the noise of motion nothing moves.

Tracker and codec leave a face that keeps still trembling about its place, by half a millimetre. Where the whole face is
that near to where it was photographed, it is brought there: the picture is as sharp as the photograph and does not
flicker. What moves by itself, lips that part or a lid that falls, is left alone.
"""

import numpy as np
from numpy.typing import NDArray

STILL_CM = 0.15  # root mean square over the face: so far from the photograph, a third is taken off what it moved
POINT_CM = 0.05  # a control point this far from where it was photographed moves a third less
OWN_CM = 0.35  # what moved this far by itself is not noise


def settle(
    places: NDArray[np.float64], photo: NDArray[np.float64], face: NDArray[np.bool_], centimetre: float, /
) -> NDArray[np.float64]:
    """Return places (V, 2) drawn towards the photograph's, (V, 2), as far as the face, (V,), is near to them.

    centimetre : its length in the units of places
    """
    moved = places - photo
    far = np.linalg.norm(moved, axis=1) / centimetre
    square = float(np.mean(np.minimum(far[face], OWN_CM) ** 2))
    return np.asarray(places - moved * np.exp(-square / STILL_CM**2 - (far / OWN_CM) ** 2)[:, None])


def settle_points(moved: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return what control points moved since the photograph, (n, 3) cm, without their noise."""
    far = np.linalg.norm(moved, axis=1, keepdims=True) / POINT_CM
    return np.asarray(moved * (1 - np.exp(-far * far)))
