"""What has come of a caller's portrait: one photograph, and a bounded number of patches laid over it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import QhullError

from conf.errors import ProtocolError
from conf.face.fapu import Fapu
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.objects import decode_object
from conf.protocol.portrait.patch import Patch
from conf.protocol.portrait.photo import NeutralPoseUpdate, Photo
from conf.receiver.portrait.decoding import decode_picture, reconstruct_patch
from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.matting import Matte, estimate_matte

MAX_PENDING = 15


@dataclass(frozen=True)
class ReceivedPhoto:
    """A photograph that is ready to be moved.

    pixels : (H, W, 3) uint8 BGR, as they came
    """

    number: int
    pixels: NDArray[np.uint8]
    cutout: Matte
    warp: PortraitWarp


@dataclass(frozen=True)
class ReceivedPatch:
    """A patch that is ready to be laid on.

    keys : (k,) float64; points : (m, 2) 0 to 1 from the upper left corner; pixels : (h, w, 3) uint8 BGR
    """

    keys: NDArray[np.float64]
    points: NDArray[np.float64]
    pixels: NDArray[np.uint8]


class PortraitStore:
    """Takes the objects as they arrive. Whatever is wrong with one is refused and counted; the call goes on."""

    def __init__(self) -> None:
        self.rejected = 0
        self.photo: ReceivedPhoto | None = None
        self.patches: dict[tuple[int, int], ReceivedPatch] = {}  # by region and slot
        self._early: list[Patch | NeutralPoseUpdate] = []  # what belongs to a photograph that has not come yet

    def receive(self, data: bytes, /) -> bool:
        """Take the bytes of an object that is whole; return whether they were good."""
        try:
            thing = decode_object(data)
            match thing:
                case Photo():
                    self._take_photograph(thing)
                case NeutralPoseUpdate():
                    self._take_neutral(thing)
                case Patch():
                    self._take_patch(thing)
        except ProtocolError:
            self.rejected += 1
            return False
        return True

    def _take_photograph(self, photo: Photo) -> None:
        pixels = decode_picture(photo.frame)
        person = person_mask(photo.outline, (pixels.shape[1], pixels.shape[0]))
        shape = PhotographedFace.from_photo(
            photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline
        )
        try:
            warp = PortraitWarp(shape)
        except (ValueError, QhullError) as error:  # points that all coincide, or lie where no mesh can be
            raise ProtocolError(f"a face that cannot be moved: {error}") from error
        self.photo = ReceivedPhoto(photo.number, pixels, estimate_matte(pixels, person), warp)
        self.patches.clear()
        early, self._early = self._early, []
        for thing in early:
            if thing.photo_number == photo.number:
                self._take_early(thing)

    def _take_early(self, thing: Patch | NeutralPoseUpdate) -> None:
        if isinstance(thing, Patch):
            self._take_patch(thing)
        else:
            self._take_neutral(thing)

    def _take_neutral(self, update: NeutralPoseUpdate) -> None:
        if self.photo is None or self.photo.number != update.photo_number:
            self._early = [*self._early[-MAX_PENDING:], update]
            return
        self.photo.warp.set_neutral(update.neutral, Fapu(*update.fapu).lengths())

    def _take_patch(self, patch: Patch) -> None:
        if self.photo is None or self.photo.number != patch.photo_number:
            self._early = [*self._early[-MAX_PENDING:], patch]
            return
        try:
            pixels = reconstruct_patch(patch, self.photo.pixels, self.photo.warp)
        except ValueError as error:  # points that all coincide
            raise ProtocolError(f"a patch that cannot be laid on: {error}") from error
        self.patches[patch.region, patch.slot] = ReceivedPatch(
            patch.descriptor.astype(np.float64), patch.points, pixels
        )
