"""Predict shut lids in a patch from the upper lid's skin in the photo.

The thin-plate spline between the control points compresses an open eye where the lids shut: white and iris appear in
the lid. A lid slides over the eyeball instead. Above the upper edge, the prediction shows what is above the upper edge
in the photo, and between the edges what is between them. The farther from the edge, the more the spline prevails.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conf.face.interpolation import smoothstep
from conf.face.portrait.eyelid_closure import EyeOpening
from conf.face.portrait.lip_lid_gaps import Opening, height_at
from conf.face.portrait.patch_features import EYES
from conf.face.portrait.patch_mapping import PatchMapping
from conf.face.portrait.warp import PortraitWarp

REACH = 2.5  # of the height that an eye has closed by: above its edge by so much the spline prevails
FULL_CLOSURE = 0.3  # of the photo's gap: from this closure on the skin slides completely
CORNER = 0.08  # of the eye's length, beyond its corners, over which the sliding ends


class LidSliding:
    """The sources of pixels in patches of the eyes of one photo."""

    def __init__(self, warp: PortraitWarp, /) -> None:
        self._warp = warp

    @cached_property
    def _mapping(self) -> PatchMapping:
        return PatchMapping(EYES, self._warp)

    def slide(
        self,
        sources: NDArray[np.float64],
        pixels: NDArray[np.float64],
        points: NDArray[np.float64],
        size: tuple[int, int],
    ) -> NDArray[np.float64]:
        """Return the sources (k, 2) in the photo, 0 to 1, of the pixels (k, 2) of a patch, with the lids slid.

        sources : those of the spline; pixels : px from the upper left corner
        points : (m, 2) the control points of the eyes in the patch, 0 to 1; size : its width and height, px
        """
        upwards = np.array([1.0, -1.0])
        mesh = self._mapping.map_vertices(points, size) * size * upwards
        for eye in self._warp.mesh.eyes:
            eye.apply(mesh)
        in_photo = np.array([self._warp.shape.aspect, -1.0])
        slid = (sources - 0.5) * in_photo
        for eye in self._warp.mesh.eyes:
            slid = _slide_lid(slid, pixels * upwards, eye, Opening.between(mesh[eye.upper], mesh[eye.lower]))
        return np.asarray(slid / in_photo + 0.5)


def _slide_lid(
    sources: NDArray[np.float64], pixels: NDArray[np.float64], eye: EyeOpening, opening: Opening
) -> NDArray[np.float64]:
    """Return sources (k, 2), image heights, of pixels (k, 2), y up. opening : of the eye in the patch"""
    scale = eye.photo.length / opening.length
    x, y = opening.coordinates(pixels)
    low, high = height_at(opening.lower, x), height_at(opening.upper, x)
    photo_low, photo_high = height_at(eye.photo.lower, x * scale), height_at(eye.photo.upper, x * scale)
    gap = (photo_high - photo_low) / scale
    closed = np.maximum(gap - (high - low), 0.0)
    above = y - high
    ratio = np.clip((y - low) / np.maximum(high - low, 1e-6), 0, 1)
    height = np.where(above > 0, photo_high + scale * above, photo_low + ratio * (photo_high - photo_low))
    beyond = np.maximum(-x, x - opening.length) / opening.length
    weight = smoothstep(1 - above / np.maximum(REACH * closed, 1e-6)) * smoothstep(1 - beyond / CORNER) * (y > low)
    weight = weight * np.clip(closed / np.maximum(FULL_CLOSURE * gap.max(), 1e-6), 0, 1)
    target = eye.photo.origin + np.outer(x * scale, eye.photo.along) + np.outer(height, eye.photo.up)
    return np.asarray(sources + weight[:, None] * (target - sources))
