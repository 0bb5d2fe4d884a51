"""Choose and build views of the head: images that show the recent frames better than what the receiver has.

Strategy: the receiver blends photo and views by shape (`head_views`), so the sender predicts for each frame of the last
ten seconds how similar the blend is to it (`face_texture`), with each of the frames as a further view. The one that
gains most is averaged over the frames it resembles, cropped to the face and encoded. It is sent if, as decoded, it
still gains. When all slots are used, a view replaces the one whose loss costs least.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.head_pose import HeadPose
from conf.face.portrait.head_views import HeadView, describe_shape, view_alpha, view_weights
from conf.face.portrait.patch_features import DESCRIPTOR_STEP, FEATURES
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.image_box import BOX_STEPS, Box
from conf.protocol.portrait.view import MAX_VIEWS, View
from conf.sender.portrait.face_texture import FaceTexture, Textures, similarities
from conf.sender.portrait.photo_averaging import average_steps
from conf.sender.portrait.photo_builder import decode_vp8, encode_vp8
from conf.sender.portrait.recent_frames import RecentFrame, nearest

# Of predicted similarity in the mean, by which a view that replaces one must improve the recent frames.
MIN_GAIN = 0.004
MIN_FIRST_GAIN = 0.002  # the same for a view in a free slot
SENT_FRACTION = 0.5  # of the gain that a view must still have as the receiver decodes it
MIN_FRAMES = 14  # of which views are chosen: 2 s
DESCRIBED_PER_CALL = 2  # frames, 2 ms each
VIEW_BYTES = 1100  # of the VP8 frame
MARGIN = 0.01  # frame heights around the face
SOFT_SIGMA = 5 / 240  # frame heights: the blur of what a view does not show

Shapes = NDArray[np.float64]


@dataclass(frozen=True)
class Shown:
    """What a frame or an image shows. shape : (2n,), from describe_shape; texture : (k,)"""

    shape: Shapes
    texture: Textures


@dataclass(frozen=True)
class ViewChoice:
    """The frame that a view shows, and those that are averaged with it, the most similar first. slot : of the view"""

    slot: int
    medoid: RecentFrame
    cluster: list[RecentFrame]


class Album:
    """The images that the receiver has or will have: one photo and its views."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (h, w, 3) uint8 BGR of the photo, as decoded"""
        self._warp = warp
        self._texture = FaceTexture(warp)
        shape = describe_shape(warp.shape.points[:CONTROL_POINT_COUNT], warp.shape.pose)
        self._photo = Shown(shape, self._texture.describe(pixels, warp.mesh.positions))
        self._views: dict[int, Shown] = {}  # by slot
        self._points: dict[int, NDArray[np.float64]] = {}  # of the views, by slot
        self._shapes: dict[int, tuple[RecentFrame, Shapes]] = {}  # by the frame's identity
        self._described: dict[int, tuple[RecentFrame, Shown]] = {}  # by the frame's identity
        self._covered: dict[int, RecentFrame] = {}  # by identity: something covers the face

    def describe(
        self,
        frames: Sequence[RecentFrame],
        /,
        *,
        is_covered: Callable[[RecentFrame], bool] = lambda _: False,
        limit: int = DESCRIBED_PER_CALL,
    ) -> None:
        """Describe at most `limit` of the frames of the last seconds, and drop those that are no longer among them.

        is_covered : whether something covers the face in a frame: it is neither shown by a view nor averaged into one
        """
        known = {id(frame): self._described.get(id(frame)) for frame in frames}
        self._described = {key: entry for key, entry in known.items() if entry is not None}
        self._covered = {key: frame for key, frame in self._covered.items() if key in known}
        new = [frame for frame in frames if known[id(frame)] is None and id(frame) not in self._covered]
        for frame in new[:limit]:
            if is_covered(frame):
                self._covered[id(frame)] = frame
                continue
            positions = self._warp.deform(frame.motion.displacements, frame.pose)
            shown = Shown(self._shape(frame), self._texture.describe(frame.pixels, positions))
            self._described[id(frame)] = frame, shown

    def choose(self) -> ViewChoice | None:
        """Choose the next view among the frames described, None if none is worth its bytes."""
        if len(self._described) < MIN_FRAMES:
            return None
        frames, shown = zip(*self._described.values(), strict=True)
        slot, kept = self._slot(shown)
        before = _similarities(shown, [self._photo, *self._views.values()])
        textures = np.array([each.texture for each in (*shown, *kept)])
        products = (textures @ textures.T).astype(np.float64)
        count = len(shown)
        shapes = np.array([each.shape for each in (*shown, *kept)])
        gains = np.empty(count)
        for index in range(count):
            rows = [*range(count), *range(count, count + len(kept)), index]
            weights = view_weights(shapes[:count], shapes[rows[count:]])
            others = np.arange(count) != index
            gains[index] = (similarities(products[np.ix_(rows, rows)], weights) - before)[others].mean()
        best = int(np.argmax(gains))
        if gains[best] < self._min_gain(slot):
            return None
        alone = np.ones((count, 1))
        rows = [*range(count), best]
        similarity = similarities(products[np.ix_(rows, rows)], alone)
        members = [i for i in np.argsort(-similarity) if i != best and similarity[i] > before[i]]
        return ViewChoice(slot, frames[best], [frames[i] for i in members])

    def add(self, view: View) -> bool:
        """Note that a view is being sent; return False if, as decoded, it gains too little to be sent."""
        box = np.array(view.box).reshape(2, 2)
        pixels = decode_vp8(view.frame)
        pose = HeadPose.from_vector(view.pose)
        head = HeadView.of_points(self._warp, view.points, pose)
        in_box = (head.positions / (self._warp.shape.aspect, -1.0) + 0.5 - box[0]) / (box[1] - box[0])
        texture = self._texture.describe_at(pixels, in_box * pixels.shape[1::-1] - 0.5)
        added = {**self._views, view.slot: Shown(head.descriptor, texture)}
        if self._described:
            shown = [entry for _, entry in self._described.values()]
            before = _similarities(shown, [self._photo, *self._views.values()])
            gain = float((_similarities(shown, [self._photo, *added.values()]) - before).mean())
            if gain < SENT_FRACTION * self._min_gain(view.slot):
                return False
        self._views = added
        self._points = {**self._points, view.slot: view.points}
        return True

    def shown_descriptors(self, frames: Sequence[RecentFrame], /) -> list[NDArray[np.float64]] | None:
        """Return for each of FEATURES the descriptors (N, k) of what photo and views together show in N frames.

        None without views: then it is the photo.
        """
        if not self._views:
            return None
        known = {id(frame): self._shapes.get(id(frame)) or (frame, self._shape(frame)) for frame in frames}
        self._shapes = known
        images = np.array([each.shape for each in (self._photo, *self._views.values())])
        weights = view_weights(np.array([shape for _, shape in known.values()]), images)
        views = (self._warp.displacements(self._points[slot]) for slot in self._views)
        shown = [self._warp.photo_displacements(), *views]
        return [weights @ (np.array([f.descriptor(each) for each in shown]) / DESCRIPTOR_STEP) for f in FEATURES]

    def _shape(self, frame: RecentFrame) -> Shapes:
        return describe_shape(self._warp.control_points(frame.motion.displacements), frame.pose)

    def _min_gain(self, slot: int) -> float:
        return MIN_GAIN if slot in self._views else MIN_FIRST_GAIN

    def _slot(self, shown: Sequence[Shown]) -> tuple[int, list[Shown]]:
        """Return the first free slot, or that of the view whose loss costs least; and the images kept beside it."""
        for slot in range(MAX_VIEWS):
            if slot not in self._views:
                return slot, [self._photo, *self._views.values()]
        kept = {slot: [self._photo, *(v for s, v in self._views.items() if s != slot)] for slot in self._views}
        slot = max(kept, key=lambda slot: float(_similarities(shown, kept[slot]).mean()))
        return slot, kept[slot]


def _similarities(shown: Sequence[Shown], images: Sequence[Shown]) -> NDArray[np.float64]:
    """Return (N,): how similar blends of the images are to N frames."""
    textures = np.array([each.texture for each in (*shown, *images)])
    weights = view_weights(np.array([each.shape for each in shown]), np.array([each.shape for each in images]))
    return similarities((textures @ textures.T).astype(np.float64), weights)


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


def _face_box(positions: NDArray[np.float64], aspect: float) -> Box:
    """Return left, top, right and bottom around positions (k, 2), 0 to 1, in steps of 1 / BOX_STEPS."""
    in_frame = positions / (aspect, -1.0) + 0.5
    margin = (MARGIN / aspect, MARGIN)
    low = np.clip(np.floor((in_frame.min(axis=0) - margin) * BOX_STEPS), 0, BOX_STEPS - 8)
    high = np.clip(np.ceil((in_frame.max(axis=0) + margin) * BOX_STEPS), low + 8, BOX_STEPS)
    left, top, right, bottom = (float(side) for side in np.concatenate([low, high]) / BOX_STEPS)
    return left, top, right, bottom


def _crop(pixels: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
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
