"""Enlarge eyes and mouth in the texture layout of the base mesh.

The layout has no folds but gives the eyes a width of only 40 texels. Each magnification is a smooth bijection of the
plane for strengths below 2.2, so that the layout stays without folds.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray


def magnify(
    uvs: NDArray[np.float64], centres: Sequence[NDArray[np.float64]], reach: float, strength: float
) -> NDArray[np.float64]:
    """Return (T, 2) coordinates moved away from the centres: magnified by 1 + strength there, unchanged far away.

    centres : (2,) each, farther apart than the reach; reach : radius of the magnification, in texture coordinates
    Raises ValueError if the layout would fold.
    """
    if not 0 <= strength < 2.2:
        raise ValueError(f"strength must be between 0 and 2.2, got {strength}")
    moved = uvs.copy()
    for centre in centres:
        offset = uvs - centre
        moved += offset * strength * np.exp(-((offset / reach) ** 2).sum(axis=1, keepdims=True))
    return moved


def spread_face(uvs: NDArray[np.float64], features: Mapping[str, NDArray[np.int64]]) -> NDArray[np.float64]:
    """Return the (T, 2) layout of the face with its front, eyes, mouth and ears enlarged.

    features : name -> indices into uvs: eye_l, eye_r, mouth, ear_l, ear_r
    """

    def middle(name: str) -> NDArray[np.float64]:
        return np.asarray((uvs[features[name]].min(axis=0) + uvs[features[name]].max(axis=0)) / 2)

    uvs = magnify(uvs, [(middle("eye_l") + middle("eye_r")) * 0.35 + middle("mouth") * 0.3], 0.22, 1.0)
    for names, reach, strength in _ENLARGED:
        uvs = magnify(uvs, [middle(name) for name in names], reach, strength)
    return uvs


_ENLARGED = ((("eye_l", "eye_r"), 0.085, 1.3), (("mouth",), 0.095, 0.9), (("ear_l", "ear_r"), 0.05, 1.0))
