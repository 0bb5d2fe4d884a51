"""Build a photo for sending from a frame and its landmarks, in steps that fit between two frames."""

import io
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from itertools import islice

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from conf.face.portrait import contours
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.photo import Photo
from conf.protocol.portrait.vp8 import strip_riff, wrap_riff
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.photo_averaging import average_steps
from conf.sender.portrait.recent_frames import RecentFrame, reduce_height
from conf.sender.portrait.segmentation import segment_steps
from conf.sender.tracking.canonical_face import CanonicalFace, remove_head_pose

BACKGROUND_BLUR = 1.2  # px: a soft background needs few bytes
BODY_BLUR = 0.8  # px
MAX_QUALITY = 92  # of 100 of WebP; higher ones gain nothing visible
_TRIES = 5  # bisection steps over the quality, to within 3; 5 ms each


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
FULL = PhotoQuality(4200, 240, 1)


class PhotoBuilder:
    """Builds one photo, some steps at a time."""

    def __init__(
        self,
        face: CapturedFace,
        canonical: CanonicalFace,
        number: int,
        quality: PhotoQuality,
        /,
        recent: Sequence[RecentFrame] = (),
    ) -> None:
        """number : of the photo, 0 to 255; recent : frames that the photo is averaged over"""
        self._steps = _build_steps(face, canonical, number, quality, recent)
        self._steps_per_slice = quality.steps_per_slice

    def advance(self) -> Photo | None:
        """Run the steps of one time slice; return the photo once it is complete."""
        return next((photo for photo in islice(self._steps, self._steps_per_slice) if photo is not None), None)


def _build_steps(
    face: CapturedFace, canonical: CanonicalFace, number: int, quality: PhotoQuality, recent: Sequence[RecentFrame]
) -> Iterator[Photo | None]:
    """Build a photo in steps shorter than a frame's interval. Yield None after each, the photo after the last."""
    height, width = face.pixels.shape[:2]
    outline = None
    for outline in segment_steps(face.pixels, face.landmarks):  # noqa: B007 -- the last one counts
        yield None
    assert outline is not None, "the last step returns the outline"
    aligned, pose = remove_head_pose(face.landmarks, canonical, (width, height))
    points, fapu = aligned[contours.PORTRAIT_LANDMARKS], astuple(face.fapu)
    small = reduce_height(face.pixels, quality.max_height)
    if recent:
        shape = PhotographedFace.from_photo((width, height), pose.to_vector(), points, face.neutral, fapu, outline)
        warp = PortraitWarp(shape)
        yield None
        for average in average_steps(small, warp, warp.mesh.positions, recent):
            small = small if average is None else average
            yield None
    softened = blur_background(small, outline, face.landmarks[:, :2] * (len(small) / height))
    frame = encode_vp8(softened, max_bytes=quality.max_bytes)
    yield None
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


def encode_vp8(pixels: NDArray[np.uint8], /, *, max_bytes: int) -> bytes:
    """Return the VP8 frame of an image (H, W, 3) uint8 BGR, at most `max_bytes` if any quality gives that."""
    image = Image.fromarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB))
    low, high = 0, MAX_QUALITY
    best: bytes | None = None
    for _ in range(_TRIES):
        quality = (low + high + 1) // 2
        frame = _encode(image, quality)
        if len(frame) <= max_bytes:
            best, low = frame, quality
        else:
            high = quality - 1
        if low >= high:
            break
    return _encode(image, 0) if best is None else best


def _encode(image: Image.Image, quality: int) -> bytes:
    file = io.BytesIO()
    image.save(file, "WEBP", quality=quality, method=6)
    return strip_riff(file.getvalue())


def decode_vp8(frame: bytes, /) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) uint8 BGR of one of our own VP8 frames, as the receiver decodes it."""
    pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    assert pixels is not None, "encode_vp8 made this frame"
    return np.asarray(pixels, dtype=np.uint8)
