"""Learn the background behind the person in a photo from frames in which the person is elsewhere.

Strategy: the mesh tells where the person's outline is in a frame. What is well outside it is background. A pixel that
the person covers in the photo is known once it has looked alike in several frames: a hand that passes, or hair that
swings, does not. If the camera moves or the light changes, the background around the person differs from the photo's,
and nothing is learned. What has been learned is sent as one small image; its other pixels are smooth and cost little.
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.portrait.photo_mesh import extend_outline
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.background import Background
from conf.protocol.portrait.image_box import BOX_STEPS
from conf.sender.portrait.photo_builder import encode_vp8
from conf.sender.portrait.recent_frames import RecentFrame

WORK_HEIGHT = 120  # px: the background is soft
MARGIN = 0.035  # image heights outside the outline that may show the person: it is some pixels off
MAX_DIFFERENCE = 6.0  # of 255: median distance of the background around the person from the photo's
MIN_SURE = 0.05  # of the frame: area of the background from which that is known
ALIKE = 12.0  # of 255: largest difference of a channel of a pixel that shows the same in two frames
MIN_COUNT = 4  # frames in which a pixel looks alike before it is known
SURPRISE = 24.0  # of 255: from here on a pixel differs from what the receiver interpolates
MIN_AREA = 0.005  # of the frame: newly known pixels of that kind that are worth sending
MIN_GROWTH = 0.5  # of the pixels sent before
MAX_BYTES = 400  # of the VP8 frame
BOX_MARGIN = 4  # px around what is known: the receiver fades the image towards its borders
SOFT_SIGMA = 8.0  # px: blur of what the receiver does not show

Mask = NDArray[np.bool_]


class BackgroundLearner:
    """Learns the background of one photo."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], number: int, /) -> None:
        """pixels : (H, W, 3) uint8 BGR of the photo; number : of the photo"""
        self._warp = warp
        self._number = number
        self._photo = _reduce(pixels)
        self._outline = extend_outline(warp.shape)
        self._nearest = cKDTree(warp.mesh.positions).query(self._outline)[1] if len(self._outline) else None
        shape = self._photo.shape[:2]
        self._covered = self._person(self._outline, shape)
        self._guess = self._fill(self._photo, self._covered)
        self._mean = np.zeros_like(self._photo)
        self._count = np.zeros(shape, np.int32)
        self._sent = np.zeros(shape, bool)

    def sample(self, frame: RecentFrame) -> None:
        """Learn from a frame of the photo's size."""
        pixels = _reduce(frame.pixels)
        if self._nearest is None or pixels.shape != self._photo.shape:
            return
        offsets = self._warp.deform(frame.motion.displacements, frame.pose) - self._warp.mesh.positions
        free = ~self._person(self._outline + offsets[self._nearest], pixels.shape[:2])
        around = free & ~self._covered
        if around.mean() < MIN_SURE or np.median(np.abs(pixels - self._photo)[around]) > MAX_DIFFERENCE:
            return
        seen = free & self._covered
        alike = seen & (np.abs(pixels - self._mean).max(axis=2) <= ALIKE)
        self._count[seen & ~alike] = 0
        self._count[seen] += 1
        weight = 1 / np.maximum(self._count, 1)[..., None]
        self._mean = np.where(seen[..., None], self._mean + weight * (pixels - self._mean), self._mean)

    @property
    def is_worth_sending(self) -> bool:
        """Whether much more is known than has been sent, and than can be interpolated."""
        known = self._count >= MIN_COUNT
        surprising = known & (np.abs(self._mean - self._guess).max(axis=2) > SURPRISE)
        new, sent = float((surprising & ~self._sent).mean()), float(self._sent.mean())
        return new >= max(MIN_AREA, MIN_GROWTH * sent)

    def build(self) -> Background:
        """Return what is known. Call it if that is worth sending."""
        known = self._count >= MIN_COUNT
        self._sent = known
        image = np.where(known[..., None], self._mean, self._photo)
        filled = self._fill(image, self._covered & ~known)
        shown = cv2.GaussianBlur(self._covered.astype(np.float32), (0, 0), 2.0)[..., None]
        shown = np.minimum(1, 2 * shown)
        filled = np.rint(shown * filled + (1 - shown) * cv2.GaussianBlur(filled, (0, 0), SOFT_SIGMA)).astype(np.uint8)
        height, width = known.shape
        y, x = np.nonzero(known)
        low = np.floor((np.array([x.min(), y.min()]) - BOX_MARGIN) / (width, height) * BOX_STEPS)
        high = np.ceil((np.array([x.max(), y.max()]) + 1 + BOX_MARGIN) / (width, height) * BOX_STEPS)
        box = np.clip(np.concatenate([low, high]), 0, BOX_STEPS) / BOX_STEPS
        left, top, right, bottom = (round(float(v)) for v in box * (width, height, width, height))
        frame = encode_vp8(np.ascontiguousarray(filled[top:bottom, left:right]), max_bytes=MAX_BYTES)
        return Background(self._number, (float(box[0]), float(box[1]), float(box[2]), float(box[3])), frame)

    def _fill(self, image: NDArray[np.float32], unknown: Mask) -> NDArray[np.uint8]:
        """Return an image (h, w, 3) with unknown pixels interpolated, about as the receiver does it."""
        pixels = np.clip(np.rint(image), 0, 255).astype(np.uint8)
        return np.asarray(cv2.inpaint(pixels, unknown.astype(np.uint8), 3, cv2.INPAINT_TELEA), np.uint8)

    def _person(self, outline: NDArray[np.float64], shape: tuple[int, ...]) -> Mask:
        """Return (h, w) whether a pixel is inside an outline (K, 2), image heights from the centre, or near it."""
        height, width = shape[:2]
        mask = np.zeros((height, width), np.uint8)
        if len(outline) < 3:
            return np.ones((height, width), bool)
        corners = np.rint((outline * (height, -height) + (width / 2, height / 2)) * 16).astype(np.int32)
        cv2.fillPoly(mask, [corners[:, None]], 1, shift=4)
        radius = max(1, round(MARGIN * height))
        disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        return np.asarray(cv2.dilate(mask, disk) > 0)


def _reduce(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return an image (H, W, 3) at WORK_HEIGHT."""
    size = round(pixels.shape[1] * WORK_HEIGHT / len(pixels)), WORK_HEIGHT
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.float32)
