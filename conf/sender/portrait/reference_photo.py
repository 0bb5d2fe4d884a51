"""The photo that the receiver has or will have, and the residual of a later frame against it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH, PatchRegion
from conf.face.portrait.patch_prediction import PatchPredictor
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.objects import decode_object
from conf.protocol.portrait.patch import POINT_STEPS
from conf.protocol.portrait.photo import Photo
from conf.sender.portrait.occlusion import AppearanceMatcher
from conf.sender.portrait.patch_extraction import extract_patch, match_colour
from conf.sender.portrait.photo_builder import decode_vp8
from conf.sender.portrait.recent_frames import RecentFrame
from conf.sender.portrait.scene_change import SceneChangeDetector, angle_between

MIN_PATCH_WEIGHT = 0.25  # below this weight of the patch the residual is faded out
MAX_PATCH_TURN = np.radians(22)  # from the photo: a patch from a head turned farther does not fit
# Minimum correlation of the skin around a feature with the photo. With a hand at the mouth it is below 0.77, while
# speaking mostly above 0.85; around the eyes nods and brows alone can lower it to 0.5.
MIN_CORRELATION = {MOUTH.name: 0.78, EYES.name: 0.5}


@dataclass(frozen=True)
class ReferencePhoto:
    """A photo in use.

    photo : decoded, as the receiver has it; pixels : its image, (H, W, 3) uint8 BGR
    """

    photo: Photo
    pixels: NDArray[np.uint8]
    warp: PortraitWarp
    predictor: PatchPredictor
    matcher: AppearanceMatcher
    scene: SceneChangeDetector

    @classmethod
    def from_bytes(cls, data: bytes, pixels: NDArray[np.uint8]) -> Self:
        """Build the reference from an encoded photo, as the receiver will.

        data : the encoded object; pixels : (H, W, 3) uint8 BGR, the frame that it shows
        """
        photo = decode_object(data)
        assert isinstance(photo, Photo)
        shape = PhotographedFace.from_photo(
            photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline
        )
        warp = PortraitWarp(shape)
        matcher, scene = AppearanceMatcher(warp, pixels), SceneChangeDetector(warp, pixels)
        decoded = decode_vp8(photo.frame)
        return cls(photo, decoded, warp, PatchPredictor(decoded, warp), matcher, scene)

    def can_patch(self, frame: RecentFrame, region: int) -> bool:
        """Whether a feature can be cut from a frame: the head is turned as in the photo, and nothing covers it."""
        if angle_between(self.warp.shape.pose, frame.pose) > MAX_PATCH_TURN:
            return False
        correlation = self.matcher.correlation(region, frame.pixels, frame.motion.displacements, frame.pose)
        return correlation >= MIN_CORRELATION[FEATURES[region].name]


def patch_residual(
    reference: ReferencePhoto, frame: RecentFrame, feature: PatchRegion, /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the residual (h, w, 3) of a frame's feature against the photo, and its control points (m, 2), 0 to 1.

    The residual is 0 where the patch has no weight. Colours are matched to the photo.
    """
    px_per_cm = float(np.exp(frame.motion.pose[5])) * len(frame.pixels)
    crop, points, weight = extract_patch(frame.pixels, frame.landmarks, feature, px_per_cm=px_per_cm)
    points = np.rint(points * POINT_STEPS) / POINT_STEPS
    size = crop.shape[1], crop.shape[0]
    predicted = reference.predictor.predict(feature, points, size)
    weight = np.minimum(1.0, weight / MIN_PATCH_WEIGHT)
    return (match_colour(crop, predicted) - predicted) * weight[..., None], points
