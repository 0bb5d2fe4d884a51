"""The photo that the receiver has or will have, and the residual of a later frame against it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import FEATURES, MOUTH, PatchRegion
from conf.face.portrait.patch_prediction import PatchPredictor
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.objects import decode_object
from conf.protocol.portrait.patch import POINT_STEPS
from conf.protocol.portrait.photo import Photo
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.occlusion import AppearanceMatcher, CoverDetector, skin_texture_residual
from conf.sender.portrait.patch_extraction import extract_patch, match_colour
from conf.sender.portrait.photo_builder import decode_vp8
from conf.sender.portrait.recent_frames import RecentFrame
from conf.sender.portrait.scene_change import SceneChangeDetector, angle_between

MIN_PATCH_WEIGHT = 0.25  # below this weight of the patch the residual is faded out
MAX_PATCH_TURN = np.radians(22)  # from the photo: a patch from a head turned farther does not fit
MIN_EYES_CORRELATION = 0.5  # of the skin around the eyes with the photo: nods and brows alone can lower it to this
# How much the skin around the mouth looks covered: the residual of CoverDetector, this much more where the correlation
# is 0, and for texture that the photo does not have. Measured with nine photos of three people: to 0.21 on bare skin,
# from 0.22 with a hand over the mouth.
CORRELATION_WEIGHT, TEXTURE_WEIGHT, USUAL_TEXTURE = 0.1, 0.5, 0.05
MAX_MOUTH_COVER = 0.215


@dataclass(frozen=True)
class ReferencePhoto:
    """A photo in use.

    photo : decoded, as the receiver has it; pixels : its image, (H, W, 3) uint8 BGR
    texture : of its skin, from skin_texture_residual
    """

    photo: Photo
    pixels: NDArray[np.uint8]
    warp: PortraitWarp
    predictor: PatchPredictor
    matcher: AppearanceMatcher
    cover: CoverDetector
    texture: float
    scene: SceneChangeDetector

    @classmethod
    def from_bytes(cls, data: bytes, face: CapturedFace) -> Self:
        """Build the reference from an encoded photo, as the receiver will.

        data : the encoded object; face : in the frame that it shows
        """
        photo = decode_object(data)
        assert isinstance(photo, Photo)
        shape = PhotographedFace.from_photo(
            photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline
        )
        warp = PortraitWarp(shape)
        matcher, cover = AppearanceMatcher(warp, face.pixels), CoverDetector(warp, face.pixels)
        scene = SceneChangeDetector(warp, face.pixels)
        texture = skin_texture_residual(face.pixels, face.landmarks)
        decoded = decode_vp8(photo.frame)
        return cls(photo, decoded, warp, PatchPredictor(decoded, warp), matcher, cover, texture, scene)

    def can_patch(self, frame: RecentFrame, region: int) -> bool:
        """Whether a feature can be cut from a frame: the head is turned as in the photo, and nothing covers it."""
        if self._turn(frame) > MAX_PATCH_TURN:
            return False
        if FEATURES[region] is MOUTH:
            return self._mouth_cover(frame) <= MAX_MOUTH_COVER
        return self._correlation(frame, region) >= MIN_EYES_CORRELATION

    def is_covered(self, frame: RecentFrame) -> bool:
        """Whether something covers mouth or jaw. A head turned too far to be compared with the photo counts as free."""
        return self._turn(frame) <= MAX_PATCH_TURN and self._mouth_cover(frame) > MAX_MOUTH_COVER

    def _mouth_cover(self, frame: RecentFrame) -> float:
        """Return how much the skin around the mouth looks covered, above MAX_MOUTH_COVER if it is."""
        correlation = self._correlation(frame, FEATURES.index(MOUTH))
        texture = skin_texture_residual(frame.pixels, frame.landmarks) - self.texture
        added = CORRELATION_WEIGHT * (1 - correlation) + TEXTURE_WEIGHT * max(0.0, texture - USUAL_TEXTURE)
        return self.cover.residual(frame) + added

    def _correlation(self, frame: RecentFrame, region: int) -> float:
        return self.matcher.correlation(region, frame.pixels, frame.motion.displacements, frame.pose)

    def _turn(self, frame: RecentFrame) -> float:
        """Return the angle from the photo's viewing direction, rad."""
        return angle_between(self.warp.shape.pose, frame.pose)


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
