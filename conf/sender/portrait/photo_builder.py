"""Make a photograph that travels out of a frame and its landmarks."""

from collections.abc import Iterator
from dataclasses import astuple, dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.fapu import Fapu
from conf.face.portrait import contours
from conf.protocol.portrait.photo import Photo
from conf.sender.portrait.photo_encoding import encode_vp8
from conf.sender.portrait.segmentation import segment_steps
from conf.sender.tracking.canonical_face import CanonicalFace
from conf.sender.tracking.pose_removal import remove_head_pose

BEHIND_BLUR = 1.2  # px: the background is not what people look at, and a soft one takes few bytes
BODY_BLUR = 0.8


@dataclass(frozen=True)
class PhotoQuality:
    """How good a photograph becomes.

    most_bytes : of its picture; most_height : px, more does not fit into the bytes
    """

    max_bytes: int
    max_height: int


DRAFT = PhotoQuality(1500, 192)  # for the first photograph, that a call may begin with a face
FULL = PhotoQuality(4700, 240)


@dataclass(frozen=True)
class CapturedFace:
    """A frame that may become a photograph.

    pixels : (H, W, 3) uint8 BGR
    landmarks : (478, 3) px
    neutral : (n, 3) cm, the neutral pose's control points
    """

    pixels: NDArray[np.uint8]
    landmarks: NDArray[np.floating]
    neutral: NDArray[np.float64]
    fapu: Fapu


def build_photo(shot: CapturedFace, canonical: CanonicalFace, number: int, /) -> Photo:
    """Return the photograph of a shot, in full."""
    for photo in build_photo_steps(shot, canonical, number, FULL):
        if photo is not None:
            return photo
    raise AssertionError("a photograph is developed in a few steps")


def build_photo_steps(
    shot: CapturedFace, canonical: CanonicalFace, number: int, finish: PhotoQuality, /
) -> Iterator[Photo | None]:
    """Make the photograph of a shot in steps of at most a frame's time each: yield None until it is there."""
    height, width = shot.pixels.shape[:2]
    outline = None
    for outline in segment_steps(shot.pixels, shot.landmarks):  # noqa: B007 -- the last one counts
        yield None
    assert outline is not None, "a person is traced in a few steps"
    scale = min(1.0, finish.max_height / height)
    small = cv2.resize(shot.pixels, (round(width * scale), round(height * scale)), interpolation=cv2.INTER_AREA)
    softened = blur_background(np.asarray(small, np.uint8), outline, shot.landmarks[:, :2] * scale)
    frame = encode_vp8(softened, max_bytes=finish.max_bytes)
    yield None
    aligned, pose = remove_head_pose(shot.landmarks, canonical, (width, height))
    points, fapu = aligned[contours.PORTRAIT_LANDMARKS], astuple(shot.fapu)
    yield Photo(number, (width, height), pose.to_vector(), points, shot.neutral, fapu, outline, frame)


def blur_background(
    pixels: NDArray[np.uint8], outline: NDArray[np.float64], landmarks: NDArray[np.floating], /
) -> NDArray[np.uint8]:
    """Return the picture with its background blurred, and a little what is far from the face: bytes for the face.

    outline : (K, 2) 0 to 1; landmarks : (478, 2) px
    """
    height, width = pixels.shape[:2]
    person = np.zeros((height, width), np.uint8)
    cv2.fillPoly(person, [np.rint(outline * (width, height)).astype(np.int32)], 255)
    person = np.asarray(cv2.dilate(person, np.ones((5, 5), np.uint8)), np.uint8)
    face = np.zeros((height, width), np.uint8)
    cv2.fillConvexPoly(face, np.rint(cv2.convexHull(landmarks.astype(np.float32))).astype(np.int32), 255)
    reach = max(3, round(0.1 * float(np.ptp(landmarks[:, 1])))) | 1
    face = np.asarray(cv2.dilate(face, np.ones((reach, reach), np.uint8)), np.uint8)
    result: NDArray[np.floating] = pixels.astype(np.float32)
    for mask, sigma in ((face, BODY_BLUR), (person, BEHIND_BLUR)):
        keep = cv2.GaussianBlur(mask, (0, 0), 2).astype(np.float32)[..., None] / 255
        result = keep * result + (1 - keep) * cv2.GaussianBlur(result, (0, 0), sigma)
    return np.asarray(np.clip(np.rint(result), 0, 255), dtype=np.uint8)
