"""The drawn person as a tracker would find him, for tests without a model."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.photographed_face import project
from conf.protocol.messages import MotionFrame
from conf.sender.portrait.photo_builder import CapturedFace
from conf.sender.tracking.canonical_face import CanonicalFace
from tests.support.drawn_person import SIZE, draw_person, to_pixels
from tests.support.synthetic_portrait import POSE, face_points


def landmarks(points: NDArray[np.float64] | None = None, pose: HeadPose = POSE) -> NDArray[np.float32]:
    """Return (478, 3) px: the outlines where they belong, all others in the middle of the face."""
    face = face_points() if points is None else points
    found = np.zeros((478, 3), np.float32)
    found[:, :2] = to_pixels(pose.position[None])
    found[contours.PORTRAIT_LANDMARKS, :2] = to_pixels(project(face, pose))
    found[contours.PORTRAIT_LANDMARKS, 2] = -(face @ pose.matrix().T)[:, 2] * np.exp(pose.log_scale) * SIZE[1]
    return found


def shot(pixels: NDArray[np.uint8] | None = None) -> CapturedFace:
    """Return a frame of the drawn person."""
    neutral = face_points()[:CONTROL_POINT_COUNT]
    return CapturedFace(draw_person() if pixels is None else pixels, landmarks(), neutral, Fapu.measure(neutral))


def motion(displacements: NDArray[np.floating] | None = None, pose: HeadPose = POSE) -> MotionFrame:
    """Return the motion of a frame."""
    moved = np.zeros((CONTROL_POINT_COUNT, 3)) if displacements is None else displacements
    return MotionFrame(0.0, moved.astype(np.float32), pose.to_vector())


def canonical() -> CanonicalFace:
    """Return a canonical face whose rigid landmarks are those of the synthetic one, so that its pose is found again."""
    vertices = np.zeros((468, 3))
    known = contours.PORTRAIT_LANDMARKS < 468
    vertices[contours.PORTRAIT_LANDMARKS[known]] = face_points()[known]
    rigid = contours.PORTRAIT_LANDMARKS[known][::4]
    return CanonicalFace(vertices, np.zeros((898, 3), np.int32), np.zeros((468, 2)), rigid, np.ones(len(rigid)))
