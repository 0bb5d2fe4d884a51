"""The photograph that the receiver has or will have, and what of a later frame can be laid over it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH, Feature
from conf.face.portrait.patch_prediction import foretell, photo_points
from conf.face.portrait.photographed_face import FaceShape
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.patch import POINT_STEPS
from conf.protocol.portrait.photo import Photograph
from conf.sender.portrait.occlusion import Agreement
from conf.sender.portrait.patch_selection import cut_out, match_light
from conf.sender.portrait.photo_builder import Shot
from conf.sender.portrait.photo_encoding import decode_picture
from conf.sender.portrait.scene_change import View

FAINT = 0.25  # of a patch: where less of it is shown nothing is corrected
PATCHABLE_TURN = np.radians(22)  # a patch from a head turned farther against the photograph would not fit
# By feature: how the skin around it must correlate with the photograph's. With a hand at the mouth it is below 0.77,
# while speaking mostly above 0.85; around the eyes nods and brows alone can bring it down to a half.
LEAST_ALIKE = {MOUTH.name: 0.78, EYES.name: 0.5}


@dataclass(frozen=True)
class Hanging:
    """A photograph in use.

    photo, pixels : as the receiver has it, and its picture (H, W, 3) uint8 BGR
    shot : the frame it was made of; taken_at : seconds
    """

    photo: Photograph
    pixels: NDArray[np.uint8]
    shot: Shot
    warp: PortraitWarp
    agreement: Agreement
    view: View
    taken_at: float

    @classmethod
    def of(cls, photo: Photograph, shot: Shot, now: float) -> Self:
        """Hang a photograph, as it will have travelled: build the warp that the receiver will build."""
        shape = FaceShape.of_photograph(photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline)
        warp, pixels = PortraitWarp(shape), decode_picture(photo.frame)
        return cls(photo, pixels, shot, warp, Agreement(warp, shot.pixels), View(warp, shot.pixels), now)

    def fits(self, shot: Shot, motion: MotionFrame, region: int) -> bool:
        """Whether a frame's feature can be laid over the photograph: seen from about there, and nothing before it."""
        pose = HeadPose.from_vector(motion.pose)
        ahead = HeadPose.from_vector(self.photo.pose).matrix()[2] @ pose.matrix()[2]
        if np.arccos(np.clip(ahead, -1, 1)) > PATCHABLE_TURN:
            return False
        alike = self.agreement.likenesses(shot.pixels, motion.displacements, pose)[region]
        return alike >= LEAST_ALIKE[FEATURES[region].name]


def differ(
    hanging: Hanging, shot: Shot, motion: MotionFrame, feature: Feature, /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how a frame's feature differs from what the photograph foretells, (h, w, 3), and its points (m, 2).

    What no patch shows does not differ; light is the photograph's.
    """
    centimetre = float(np.exp(motion.pose[5])) * len(shot.pixels)
    cut = cut_out(shot.pixels, shot.landmarks, feature, centimetre=centimetre)
    points = np.rint(cut.points * POINT_STEPS) / POINT_STEPS
    size = cut.pixels.shape[1], cut.pixels.shape[0]
    foretold = foretell(hanging.pixels, photo_points(hanging.warp, feature), points, size)
    seen = np.minimum(1.0, cut.seen / FAINT)
    return (match_light(cut.pixels, foretold) - foretold) * seen[..., None], points
