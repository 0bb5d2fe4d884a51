"""Build a photo for sending from a frame and its landmarks, in steps that fit between two frames."""

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from itertools import islice

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

BACKGROUND_BLUR = 1.2  # px: a soft background needs few bytes
BODY_BLUR = 0.8  # px


@dataclass(frozen=True)
class PhotoQuality:
    """The limits of a photo.

    max_bytes : of its VP8 frame; max_height : px, more does not fit into the bytes
    steps_per_slice : build steps between two frames
    """

    max_bytes: int
    max_height: int
    steps_per_slice: int


DRAFT = PhotoQuality(1500, 192, 3)  # the first photo, so that a call starts with a face
FULL = PhotoQuality(4700, 240, 1)


@dataclass(frozen=True)
class CapturedFace:
    """A frame that may become a photo.

    pixels : (H, W, 3) uint8 BGR
    landmarks : (478, 3) px
    neutral : (n, 3) cm in face axes, the control points of the neutral pose in use
    """

    pixels: NDArray[np.uint8]
    landmarks: NDArray[np.floating]
    neutral: NDArray[np.float64]
    fapu: Fapu


class PhotoBuilder:
    """Builds one photo, some steps at a time."""

    def __init__(self, face: CapturedFace, canonical: CanonicalFace, number: int, quality: PhotoQuality, /) -> None:
        """number : of the photo, 0 to 255"""
        self._steps = _build_steps(face, canonical, number, quality)
        self._steps_per_slice = quality.steps_per_slice

    def advance(self) -> Photo | None:
        """Run the steps of one time slice; return the photo once it is complete."""
        return next((photo for photo in islice(self._steps, self._steps_per_slice) if photo is not None), None)


def build_photo(face: CapturedFace, canonical: CanonicalFace, number: int, /) -> Photo:
    """Return the photo of a frame in full quality."""
    *_, photo = _build_steps(face, canonical, number, FULL)
    assert photo is not None, "the last step returns the photo"
    return photo


def _build_steps(
    face: CapturedFace, canonical: CanonicalFace, number: int, quality: PhotoQuality
) -> Iterator[Photo | None]:
    """Build a photo in steps shorter than a frame's interval. Yield None after each, the photo after the last."""
    height, width = face.pixels.shape[:2]
    outline = None
    for outline in segment_steps(face.pixels, face.landmarks):  # noqa: B007 -- the last one counts
        yield None
    assert outline is not None, "the last step returns the outline"
    scale = min(1.0, quality.max_height / height)
    small = cv2.resize(face.pixels, (round(width * scale), round(height * scale)), interpolation=cv2.INTER_AREA)
    softened = blur_background(np.asarray(small, np.uint8), outline, face.landmarks[:, :2] * scale)
    frame = encode_vp8(softened, max_bytes=quality.max_bytes)
    yield None
    aligned, pose = remove_head_pose(face.landmarks, canonical, (width, height))
    points, fapu = aligned[contours.PORTRAIT_LANDMARKS], astuple(face.fapu)
    yield Photo(number, (width, height), pose.to_vector(), points, face.neutral, fapu, outline, frame)


def blur_background(
    pixels: NDArray[np.uint8], outline: NDArray[np.float64], landmarks: NDArray[np.floating], /
) -> NDArray[np.uint8]:
    """Return the image with the background blurred, and the body slightly, so that most bytes go to the face.

    outline : (K, 2) 0 to 1; landmarks : (478, 2) px
    """
    height, width = pixels.shape[:2]
    person, face = np.zeros((2, height, width), np.uint8)
    cv2.fillPoly(person, [np.rint(outline * (width, height)).astype(np.int32)], 255)
    cv2.fillConvexPoly(face, np.rint(cv2.convexHull(landmarks.astype(np.float32))).astype(np.int32), 255)
    margin = max(3, round(0.1 * float(np.ptp(landmarks[:, 1])))) | 1
    result: NDArray[np.floating] = pixels.astype(np.float32)
    for mask, side, sigma in ((face, margin, BODY_BLUR), (person, 5, BACKGROUND_BLUR)):
        dilated = cv2.dilate(mask, np.ones((side, side), np.uint8))
        keep = cv2.GaussianBlur(dilated, (0, 0), 2).astype(np.float32)[..., None] / 255
        result = keep * result + (1 - keep) * cv2.GaussianBlur(result, (0, 0), sigma)
    return np.asarray(np.clip(np.rint(result), 0, 255), dtype=np.uint8)
