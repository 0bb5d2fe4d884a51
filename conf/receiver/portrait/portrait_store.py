"""Keep what has been received of a participant's portrait: one photo and a bounded number of patches for it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import QhullError

from conf.errors import ProtocolError
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait.head_views import HeadView
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import PatchPredictor, inverse_dct
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.background import Background
from conf.protocol.portrait.objects import decode_object
from conf.protocol.portrait.patch import Patch, step_size
from conf.protocol.portrait.photo import NeutralPoseUpdate, Photo
from conf.protocol.portrait.view import View
from conf.protocol.portrait.vp8 import read_frame_size, wrap_riff
from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.learned_background import add_background
from conf.receiver.portrait.matting import Matte, estimate_matte

MAX_PENDING = 15  # older objects kept, besides the newest, that wait for their photo


@dataclass(frozen=True)
class ReceivedPhoto:
    """A photo that is ready to be drawn.

    pixels : (H, W, 3) uint8 BGR, as decoded; person : (H, W) uint8, from person_mask
    """

    number: int
    pixels: NDArray[np.uint8]
    person: NDArray[np.uint8]
    matte: Matte
    warp: PortraitWarp
    predictor: PatchPredictor


@dataclass(frozen=True)
class ReceivedPatch:
    """A patch that is ready to be drawn.

    descriptor : (k,) float64; points : (m, 2) 0 to 1 from the upper left corner; pixels : (h, w, 3) uint8 BGR
    """

    descriptor: NDArray[np.float64]
    points: NDArray[np.float64]
    pixels: NDArray[np.uint8]


@dataclass(frozen=True)
class ReceivedView:
    """A view that is ready to be drawn.

    points : (n, 3) cm in face axes: the control points
    uvs : (V, 2) of the mesh in the image, 0 to 1 from its upper left corner, or outside; pixels : (h, w, 3) uint8 BGR
    """

    head: HeadView
    points: NDArray[np.float64]
    uvs: NDArray[np.float64]
    pixels: NDArray[np.uint8]


class PortraitStore:
    """Decodes portrait objects as they arrive. An invalid one is rejected and counted; the call continues."""

    def __init__(self) -> None:
        self.rejected = 0
        self.photo: ReceivedPhoto | None = None
        self.backdrop: NDArray[np.uint8] | None = None  # (H, W, 3) BGR, of the photo, with what was learned later
        self.patches: dict[tuple[int, int], ReceivedPatch] = {}  # by region and slot
        self.views: dict[int, ReceivedView] = {}  # by slot
        self._pending: list[Patch | NeutralPoseUpdate | View | Background] = []  # of a photo that has not arrived yet

    def receive(self, data: bytes, /) -> bool:
        """Decode the bytes of a complete object; return whether they were valid."""
        try:
            received = decode_object(data)
            if isinstance(received, Photo):
                self._receive_photo(received)
            else:
                self._receive_update(received)
        except ProtocolError:
            self.rejected += 1
            return False
        return True

    def _receive_photo(self, photo: Photo) -> None:
        pixels = decode_image(photo.frame)
        person = person_mask(photo.outline, (pixels.shape[1], pixels.shape[0]))
        face = PhotographedFace.from_photo(
            photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline
        )
        try:
            warp = PortraitWarp(face)
        except (ValueError, QhullError) as error:  # points that coincide or have no valid mesh
            raise ProtocolError(f"a face that cannot be moved: {error}") from error
        matte, predictor = estimate_matte(pixels, person), PatchPredictor(pixels, warp)
        self.photo = ReceivedPhoto(photo.number, pixels, person, matte, warp, predictor)
        self.backdrop = matte.backdrop
        self.patches.clear()
        self.views.clear()
        pending, self._pending = self._pending, []
        for update in pending:
            if update.photo_number == photo.number:
                self._receive_update(update)

    def _receive_update(self, update: Patch | NeutralPoseUpdate | View | Background) -> None:
        """Apply an object to the photo it belongs to, or keep it until that photo arrives."""
        if self.photo is None or self.photo.number != update.photo_number:
            self._pending = [*self._pending[-MAX_PENDING:], update]
            return
        if isinstance(update, NeutralPoseUpdate):
            self.photo.warp.set_neutral(update.neutral, Fapu(*update.fapu).lengths())
            return
        if isinstance(update, View):
            self.views[update.slot] = load_view(update, self.photo.warp)
            return
        if isinstance(update, Background):
            photo, image = self.photo, decode_image(update.frame)
            self.backdrop = add_background(photo.matte.backdrop, photo.pixels, photo.person, image, update.box)
            return
        try:
            pixels = reconstruct_patch(update, self.photo.predictor)
        except ValueError as error:  # points that coincide
            raise ProtocolError(f"a patch that cannot be drawn: {error}") from error
        descriptor = update.descriptor.astype(np.float64)
        self.patches[update.region, update.slot] = ReceivedPatch(descriptor, update.points, pixels)


def decode_image(frame: bytes, /) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR. Raises ProtocolError if the bytes are no VP8 frame of the size in its header."""
    width, height = read_frame_size(frame)
    try:
        pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise ProtocolError("an image that cannot be decoded") from error
    if pixels is None or pixels.shape != (height, width, 3):
        raise ProtocolError("an image that cannot be decoded")
    return np.asarray(pixels, dtype=np.uint8)


def load_view(view: View, warp: PortraitWarp, /) -> ReceivedView:
    """Return a view that is ready to be drawn. Raises ProtocolError if its image cannot be decoded."""
    head = HeadView.of_points(warp, view.points, HeadPose.from_vector(view.pose))
    in_frame = head.positions / (warp.shape.aspect, -1.0) + 0.5
    low, high = np.array(view.box[:2]), np.array(view.box[2:])
    return ReceivedView(head, view.points, (in_frame - low) / (high - low), decode_image(view.frame))


def reconstruct_patch(patch: Patch, predictor: PatchPredictor, /) -> NDArray[np.uint8]:
    """Return a patch's pixels (h, w, 3) uint8 BGR: its prediction from the photo plus its residual.

    Raises ValueError if the patch's points coincide.
    """
    residual = inverse_dct([plane * step_size(patch.step) for plane in patch.coefficients], patch.size)
    pixels = predictor.predict(FEATURES[patch.region], patch.points, patch.size) + residual
    return np.asarray(np.clip(np.rint(pixels), 0, 255), dtype=np.uint8)
