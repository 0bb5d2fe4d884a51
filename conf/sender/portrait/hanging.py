"""The photograph that the receiver has or will have, and what of a later frame can be laid over it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LANDMARKS
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait.features import EYES, FEATURES, MOUTH, Feature
from conf.face.portrait.shape import FaceShape
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.photograph import Photograph
from conf.sender.portrait.agreement import Agreement
from conf.sender.portrait.patchwork import cut_patch, match_light
from conf.sender.portrait.photographer import Shot
from conf.sender.portrait.view import View

PATCHABLE_TURN = np.radians(22)  # a patch from a head turned farther against the photograph would not fit
# By feature: how the skin around it must correlate with the photograph's. With a hand at the mouth it is below 0.77,
# while speaking mostly above 0.85; around the eyes nods and brows alone can bring it down to a half.
LEAST_ALIKE = {MOUTH.name: 0.78, EYES.name: 0.5}


@dataclass(frozen=True)
class Hanging:
    """A photograph in use.

    shot : the frame it was made of; taken_at : seconds
    """

    photo: Photograph
    shot: Shot
    warp: PortraitWarp
    agreement: Agreement
    view: View
    taken_at: float

    @classmethod
    def of(cls, photo: Photograph, shot: Shot, now: float) -> Self:
        """Hang a photograph: build the warp that the receiver will build."""
        aspect = photo.size[0] / photo.size[1]
        shape = FaceShape(
            aspect,
            HeadPose.from_vector(photo.pose),
            photo.points,
            photo.neutral,
            Fapu(*photo.fapu).lengths(),
            (photo.outline - 0.5) * (aspect, -1.0),
        )
        warp = PortraitWarp(shape)
        return cls(photo, shot, warp, Agreement(warp, shot.pixels), View(warp, shot.pixels), now)

    def fits(self, shot: Shot, motion: MotionFrame, region: int) -> bool:
        """Whether a frame's feature can be laid over the photograph: seen from about there, and nothing before it."""
        pose = HeadPose.from_vector(motion.pose)
        ahead = HeadPose.from_vector(self.photo.pose).matrix()[2] @ pose.matrix()[2]
        if np.arccos(np.clip(ahead, -1, 1)) > PATCHABLE_TURN:
            return False
        alike = self.agreement.likenesses(shot.pixels, motion.displacements, pose)[region]
        return alike >= LEAST_ALIKE[FEATURES[region].name]


def cut_for(
    hanging: Hanging, shot: Shot, motion: MotionFrame, feature: Feature, /
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return a feature cut out of a frame in the photograph's light, and its control points (m, 2) in the cut-out."""
    centimetre = float(np.exp(motion.pose[5])) * len(shot.pixels)
    pixels, points = cut_patch(shot.pixels, shot.landmarks, feature, centimetre=centimetre)
    size = np.array(hanging.shot.pixels.shape[1::-1])
    photo_points = hanging.shot.landmarks[LANDMARKS[list(feature.points)], :2] / size
    return match_light(pixels, points, hanging.shot.pixels, photo_points), points
