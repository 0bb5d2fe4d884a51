"""Spread the base mesh's texture layout so that eyes and mouth get more of the picture than the scalp.

The layout has no folds but leaves the eyes 40 texels wide. Each magnification below is a smooth map of the plane onto
itself that keeps its order (strengths under 2.2), so the layout stays without folds.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray


def magnify(
    uvs: NDArray[np.float64], centres: Sequence[NDArray[np.float64]], reach: float, strength: float
) -> NDArray[np.float64]:
    """Return (T, 2) coordinates moved away from the centres: 1 + strength times larger there, unmoved far off.

    centres : (2,) each, farther apart than the reach; reach : where the magnification fades, in the layout's own unit
    Raises ValueError if the layout would fold.
    """
    if not 0 <= strength < 2.2:
        raise ValueError(f"strength must lie between 0 and 2.2, got {strength}")
    moved = uvs.copy()
    for centre in centres:
        offset = uvs - centre
        moved += offset * strength * np.exp(-((offset / reach) ** 2).sum(axis=1, keepdims=True))
    return moved


def spread_face(uvs: NDArray[np.float64], marks: Mapping[str, NDArray[np.int64]]) -> NDArray[np.float64]:
    """Return the face's (T, 2) layout with its front, the eyes, the mouth and the ears enlarged.

    marks : name -> indices into uvs: eye_l, eye_r, mouth, ear_l, ear_r
    """

    def middle(name: str) -> NDArray[np.float64]:
        return np.asarray((uvs[marks[name]].min(axis=0) + uvs[marks[name]].max(axis=0)) / 2)

    uvs = magnify(uvs, [(middle("eye_l") + middle("eye_r")) * 0.35 + middle("mouth") * 0.3], 0.22, 1.0)
    for names, reach, strength in _ENLARGED:
        uvs = magnify(uvs, [middle(name) for name in names], reach, strength)
    return uvs


_ENLARGED = (
    (("eye_l", "eye_r"), 0.085, 1.3),
    (("mouth",), 0.095, 0.9),
    (("ear_l", "ear_r"), 0.05, 1.0),
)
