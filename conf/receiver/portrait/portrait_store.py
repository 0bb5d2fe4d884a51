"""Keep what has been received of a participant's portrait: one photo and a bounded number of patches for it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import QhullError

from conf.errors import ProtocolError
from conf.face.fapu import Fapu
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import inverse_dct, predict_patch, region_points_in_photo
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.objects import decode_object
from conf.protocol.portrait.patch import Patch, step_size
from conf.protocol.portrait.photo import NeutralPoseUpdate, Photo
from conf.protocol.portrait.vp8 import read_frame_size, wrap_riff
from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.matting import Matte, estimate_matte

MAX_PENDING = 15  # older objects kept, besides the newest, that wait for their photo


@dataclass(frozen=True)
class ReceivedPhoto:
    """A photo that is ready to be drawn. pixels : (H, W, 3) uint8 BGR, as decoded"""

    number: int
    pixels: NDArray[np.uint8]
    matte: Matte
    warp: PortraitWarp


@dataclass(frozen=True)
class ReceivedPatch:
    """A patch that is ready to be drawn.

    descriptor : (k,) float64; points : (m, 2) 0 to 1 from the upper left corner; pixels : (h, w, 3) uint8 BGR
    """

    descriptor: NDArray[np.float64]
    points: NDArray[np.float64]
    pixels: NDArray[np.uint8]


class PortraitStore:
    """Decodes portrait objects as they arrive. An invalid one is rejected and counted; the call continues."""

    def __init__(self) -> None:
        self.rejected = 0
        self.photo: ReceivedPhoto | None = None
        self.patches: dict[tuple[int, int], ReceivedPatch] = {}  # by region and slot
        self._pending: list[Patch | NeutralPoseUpdate] = []  # of a photo that has not arrived yet

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
        self.photo = ReceivedPhoto(photo.number, pixels, estimate_matte(pixels, person), warp)
        self.patches.clear()
        pending, self._pending = self._pending, []
        for update in pending:
            if update.photo_number == photo.number:
                self._receive_update(update)

    def _receive_update(self, update: Patch | NeutralPoseUpdate) -> None:
        """Apply a patch or neutral pose to the photo it belongs to, or keep it until that photo arrives."""
        if self.photo is None or self.photo.number != update.photo_number:
            self._pending = [*self._pending[-MAX_PENDING:], update]
            return
        if isinstance(update, NeutralPoseUpdate):
            self.photo.warp.set_neutral(update.neutral, Fapu(*update.fapu).lengths())
            return
        try:
            pixels = reconstruct_patch(update, self.photo.pixels, self.photo.warp)
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


def reconstruct_patch(patch: Patch, photo: NDArray[np.uint8], warp: PortraitWarp, /) -> NDArray[np.uint8]:
    """Return a patch's pixels (h, w, 3) uint8 BGR: its prediction from the photo (H, W, 3) plus its residual.

    Raises ValueError if the patch's points coincide.
    """
    points = region_points_in_photo(warp, FEATURES[patch.region])
    residual = inverse_dct([plane * step_size(patch.step) for plane in patch.coefficients], patch.size)
    pixels = predict_patch(photo, points, patch.points, patch.size) + residual
    return np.asarray(np.clip(np.rint(pixels), 0, 255), dtype=np.uint8)
