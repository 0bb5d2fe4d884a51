"""Choose and build views of the head: the poses and expressions that are often far from all images the receiver has.

Strategy: the frames of the last ten seconds are clustered by their shape. The next view is the medoid that brings them
nearest to an image: greedy k-medoids, photo and views being fixed. It is averaged over its cluster, cropped to the face
and encoded. When all slots are used, a view replaces the one that the frames need least.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait.head_views import HeadView, describe_shape, view_alpha
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.view import BOX_STEPS, MAX_VIEWS, View
from conf.sender.portrait.photo_averaging import average_steps
from conf.sender.portrait.photo_builder import encode_vp8
from conf.sender.portrait.recent_frames import RecentFrame, nearest

MIN_GAIN_CM = 0.025  # by which a view must bring the frames nearer to an image, in the mean
MIN_DISTANCE_CM = 0.12  # of a view from each image
MIN_FRAMES = 14  # of which views are chosen: 2 s
VIEW_BYTES = 1600  # of the VP8 frame
MARGIN = 0.01  # frame heights around the face
SOFT_SIGMA = 5 / 240  # frame heights: the blur of what a view does not show

Shapes = NDArray[np.float64]


def frame_shapes(warp: PortraitWarp, frames: Sequence[RecentFrame], /) -> Shapes:
    """Return (N, 2n) the descriptors of frames, cm RMS."""
    shapes = [describe_shape(warp.control_points(frame.motion.displacements), frame.pose) for frame in frames]
    return np.asarray(np.array(shapes).reshape(len(frames), -1) / np.sqrt(CONTROL_POINT_COUNT), np.float64)


def distances(a: Shapes, b: Shapes, /) -> NDArray[np.float64]:
    """Return (N, M) the distances of shapes (N, k) and (M, k)."""
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1) - 2 * a @ b.T
    return np.asarray(np.sqrt(np.maximum(squares, 0)))


@dataclass(frozen=True)
class ViewChoice:
    """The frame that a view shows, and those that are averaged with it. slot : of the view"""

    slot: int
    medoid: RecentFrame
    cluster: list[RecentFrame]


class Album:
    """The views that the receiver has or will have, for one photo."""

    def __init__(self, warp: PortraitWarp, photo_shape: Shapes, /) -> None:
        """photo_shape : (1, 2n) of the photo, from frame_shapes"""
        self._warp = warp
        self._photo_shape = photo_shape
        self._shapes: dict[int, Shapes] = {}  # (1, 2n), by slot

    @property
    def slots(self) -> list[int]:
        """Slots of the views that the receiver has or will have."""
        return list(self._shapes)

    def choose(self, frames: Sequence[RecentFrame], /) -> ViewChoice | None:
        """Choose the next view among frames of the last seconds, None if none is worth its bytes."""
        if len(frames) < MIN_FRAMES:
            return None
        shapes = frame_shapes(self._warp, frames)
        slot = self._free_slot(shapes)
        known = np.concatenate([self._photo_shape, *(shape for s, shape in self._shapes.items() if s != slot)])
        current = np.concatenate([known, self._shapes[slot]]) if slot in self._shapes else known
        to_current = distances(shapes, current).min(axis=1)
        to_known, between = distances(shapes, known).min(axis=1), distances(shapes, shapes)
        gains = to_current.mean() - np.minimum(to_known[:, None], between).mean(axis=0)
        gains[to_current < MIN_DISTANCE_CM] = 0.0
        best = int(np.argmax(gains))
        if gains[best] < MIN_GAIN_CM:
            return None
        members = [i for i in np.argsort(between[best]) if i != best and between[best, i] < to_known[i]]
        return ViewChoice(slot, frames[best], [frames[i] for i in members])

    def add(self, choice: ViewChoice) -> None:
        """Note that a view is being sent."""
        self._shapes[choice.slot] = frame_shapes(self._warp, [choice.medoid])

    def _free_slot(self, shapes: Shapes) -> int:
        """Return the first free slot, or the one whose view the frames need least."""
        free = [slot for slot in range(MAX_VIEWS) if slot not in self._shapes]
        if free:
            return free[0]

        def mean_without(slot: int) -> float:
            others = np.concatenate([self._photo_shape, *(s for o, s in self._shapes.items() if o != slot)])
            return float(distances(shapes, others).min(axis=1).mean())

        return min(self._shapes, key=mean_without)


def view_steps(choice: ViewChoice, warp: PortraitWarp, photo_number: int, /) -> Iterator[View | None]:
    """Build a view in steps shorter than a frame's interval. Yield None after each, the view after the last."""
    medoid = choice.medoid
    points = warp.control_points(medoid.motion.displacements)
    head = HeadView.of_points(warp, points, medoid.pose)
    pixels = medoid.pixels
    yield None
    for average in average_steps(pixels, warp, head.positions, nearest(choice.cluster)):
        pixels = pixels if average is None else average
        yield None
    alpha = view_alpha(warp)
    box = _face_box(head.positions[alpha > 0], pixels.shape[1] / len(pixels))
    pixels = _crop(_soften_outside(pixels, head.positions, alpha, warp), box)
    frame = encode_vp8(pixels, max_bytes=VIEW_BYTES)
    yield View(photo_number, choice.slot, medoid.motion.pose.astype(np.float64), points, box, frame)


def _face_box(positions: NDArray[np.float64], aspect: float) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom around positions (k, 2), 0 to 1, in steps of 1 / BOX_STEPS."""
    in_frame = positions / (aspect, -1.0) + 0.5
    margin = (MARGIN / aspect, MARGIN)
    low = np.clip(np.floor((in_frame.min(axis=0) - margin) * BOX_STEPS), 0, BOX_STEPS - 8)
    high = np.clip(np.ceil((in_frame.max(axis=0) + margin) * BOX_STEPS), low + 8, BOX_STEPS)
    left, top, right, bottom = (float(side) for side in np.concatenate([low, high]) / BOX_STEPS)
    return left, top, right, bottom


def _crop(pixels: NDArray[np.uint8], box: tuple[float, float, float, float]) -> NDArray[np.uint8]:
    """Return the box of an image, resampled so that its borders are those of the box."""
    height, width = pixels.shape[:2]
    left, top, right, bottom = box[0] * width, box[1] * height, box[2] * width, box[3] * height
    size = max(1, round(right - left)), max(1, round(bottom - top))
    scale = np.array([(right - left) / size[0], (bottom - top) / size[1]])
    shift = np.array([left, top]) + 0.5 * scale - 0.5
    matrix = np.array([[scale[0], 0, shift[0]], [0, scale[1], shift[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(pixels, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), np.uint8)


def _soften_outside(
    pixels: NDArray[np.uint8], positions: NDArray[np.float64], alpha: NDArray[np.float64], warp: PortraitWarp
) -> NDArray[np.uint8]:
    """Return the image blurred where the view is transparent, so that its bytes go to the face."""
    height, width = pixels.shape[:2]
    shown = warp.mesh.triangles[(alpha[warp.mesh.triangles] > 0.2).any(axis=1)]
    corners = np.rint(positions * (height, -height) + (width / 2, height / 2) - 0.5).astype(np.int32)
    mask = np.zeros((height, width), np.uint8)
    for triangle in corners[shown]:
        cv2.fillConvexPoly(mask, triangle, 255)
    keep = cv2.GaussianBlur(mask, (0, 0), 1.5).astype(np.float32)[..., None] / 255
    soft = cv2.GaussianBlur(pixels, (0, 0), SOFT_SIGMA * height)
    return np.asarray(np.clip(np.rint(keep * pixels + (1 - keep) * soft), 0, 255), np.uint8)
