"""The drawn person as a tracker would find him, for tests without a model."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.photographed_face import project
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.photo import Photo
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.photo_builder import FULL, PhotoBuilder
from conf.sender.portrait.recent_frames import RecentFrame
from conf.sender.tracking.canonical_face import CanonicalFace
from tests.support.drawn_person import SIZE, draw_person, to_pixels
from tests.support.synthetic_portrait import POSE, face_points


def still() -> NDArray[np.float64]:
    """Return the displacements (n, 3) of a neutral face."""
    return np.zeros((CONTROL_POINT_COUNT, 3))


def shaded_person(light: float = 1.0, offset: float = 0.0) -> NDArray[np.uint8]:
    """Return the drawn person lit from the side: evenly lit skin has no pattern to compare."""
    shaded = np.clip(draw_person() * np.linspace(0.5, 1.1, SIZE[0])[None, :, None], 0, 255).astype(np.uint8)
    return np.clip(shaded * light + offset, 0, 255).astype(np.uint8)


def landmarks(points: NDArray[np.float64] | None = None, pose: HeadPose = POSE) -> NDArray[np.float32]:
    """Return (478, 3) px: those of the portrait in position, all others in the middle of the face."""
    face = face_points() if points is None else points
    found = np.zeros((478, 3), np.float32)
    found[:, :2] = to_pixels(pose.position[None])
    found[contours.PORTRAIT_LANDMARKS, :2] = to_pixels(project(face, pose))
    found[contours.PORTRAIT_LANDMARKS, 2] = -(face @ pose.matrix().T)[:, 2] * np.exp(pose.log_scale) * SIZE[1]
    return found


def captured_face(pixels: NDArray[np.uint8] | None = None) -> CapturedFace:
    """Return a frame of the drawn person."""
    neutral = face_points()[:CONTROL_POINT_COUNT]
    return CapturedFace(draw_person() if pixels is None else pixels, landmarks(), neutral, Fapu.measure(neutral))


def motion(displacements: NDArray[np.floating] | None = None, pose: HeadPose = POSE) -> MotionFrame:
    """Return the motion of a frame."""
    moved = still() if displacements is None else displacements
    return MotionFrame(0.0, moved.astype(np.float32), pose.to_vector())


def recent_frame(
    pixels: NDArray[np.uint8] | None = None, moved: MotionFrame | None = None, penalty: float = 0.0
) -> RecentFrame:
    """Return a frame of the drawn person among the recent ones."""
    return RecentFrame.reduced(captured_face(pixels), motion() if moved is None else moved, penalty, SIZE[1])


def with_hand() -> NDArray[np.uint8]:
    """Return the person with a bright hand over mouth and jaw."""
    pixels = shaded_person()
    x, y = landmarks()[17, :2].astype(int).tolist()
    cv2.ellipse(pixels, (x - 20, y), (26, 30), 0, 0, 360, (235, 235, 235), -1)
    return pixels


def canonical() -> CanonicalFace:
    """Return a canonical face whose rigid landmarks are those of the synthetic one, so that its pose is found again."""
    vertices = np.zeros((468, 3))
    known = contours.PORTRAIT_LANDMARKS < 468
    vertices[contours.PORTRAIT_LANDMARKS[known]] = face_points()[known]
    rigid = contours.PORTRAIT_LANDMARKS[known][::4]
    return CanonicalFace(vertices, np.zeros((898, 3), np.int32), rigid, np.ones(len(rigid)))


def build_photo(face: CapturedFace, number: int = 1) -> Photo:
    """Return the photo of a frame in full quality."""
    photo = PhotoBuilder(face, canonical(), number, replace(FULL, steps_per_slice=100)).advance()
    assert photo is not None
    return photo
