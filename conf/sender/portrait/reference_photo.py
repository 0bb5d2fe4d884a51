"""The photograph that the receiver has or will have, and what of a later frame can be laid over it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH, PatchRegion
from conf.face.portrait.patch_prediction import predict_patch, region_points_in_photo
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.patch import POINT_STEPS
from conf.protocol.portrait.photo import Photo
from conf.sender.portrait.occlusion import AppearanceMatcher
from conf.sender.portrait.patch_selection import extract_patch, match_colour
from conf.sender.portrait.photo_builder import CapturedFace
from conf.sender.portrait.photo_encoding import decode_vp8
from conf.sender.portrait.scene_change import SceneChangeDetector

MIN_PATCH_WEIGHT = 0.25  # of a patch: where less of it is shown nothing is corrected
PATCHABLE_TURN = np.radians(22)  # a patch from a head turned farther against the photograph would not fit
# By feature: how the skin around it must correlate with the photograph's. With a hand at the mouth it is below 0.77,
# while speaking mostly above 0.85; around the eyes nods and brows alone can bring it down to a half.
MIN_CORRELATION = {MOUTH.name: 0.78, EYES.name: 0.5}


@dataclass(frozen=True)
class ReferencePhoto:
    """A photograph in use.

    photo, pixels : as the receiver has it, and its picture (H, W, 3) uint8 BGR
    shot : the frame it was made of; taken_at : seconds
    """

    photo: Photo
    pixels: NDArray[np.uint8]
    shot: CapturedFace
    warp: PortraitWarp
    agreement: AppearanceMatcher
    view: SceneChangeDetector
    taken_at: float

    @classmethod
    def create(cls, photo: Photo, shot: CapturedFace, now: float) -> Self:
        """Hang a photograph, as it will have travelled: build the warp that the receiver will build."""
        shape = PhotographedFace.from_photo(
            photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline
        )
        warp, pixels = PortraitWarp(shape), decode_vp8(photo.frame)
        return cls(
            photo, pixels, shot, warp, AppearanceMatcher(warp, shot.pixels), SceneChangeDetector(warp, shot.pixels), now
        )

    def can_patch(self, shot: CapturedFace, motion: MotionFrame, region: int) -> bool:
        """Whether a frame's feature can be laid over the photograph: seen from about there, and nothing before it."""
        pose = HeadPose.from_vector(motion.pose)
        ahead = HeadPose.from_vector(self.photo.pose).matrix()[2] @ pose.matrix()[2]
        if np.arccos(np.clip(ahead, -1, 1)) > PATCHABLE_TURN:
            return False
        alike = self.agreement.region_correlations(shot.pixels, motion.displacements, pose)[region]
        return alike >= MIN_CORRELATION[FEATURES[region].name]


def patch_residual(
    hanging: ReferencePhoto, shot: CapturedFace, motion: MotionFrame, feature: PatchRegion, /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how a frame's feature differs from what the photograph foretells, (h, w, 3), and its points (m, 2).

    What no patch shows does not differ; light is the photograph's.
    """
    centimetre = float(np.exp(motion.pose[5])) * len(shot.pixels)
    cut = extract_patch(shot.pixels, shot.landmarks, feature, centimetre=centimetre)
    points = np.rint(cut.points * POINT_STEPS) / POINT_STEPS
    size = cut.pixels.shape[1], cut.pixels.shape[0]
    foretold = predict_patch(hanging.pixels, region_points_in_photo(hanging.warp, feature), points, size)
    seen = np.minimum(1.0, cut.seen / MIN_PATCH_WEIGHT)
    return (match_colour(cut.pixels, foretold) - foretold) * seen[..., None], points
