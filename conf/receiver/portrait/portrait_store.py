"""What has come of a caller's portrait: one photograph, and a bounded number of patches laid over it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import QhullError

from conf.errors import ProtocolError
from conf.face.fapu import Fapu
from conf.face.portrait.photographed_face import FaceShape
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.objects import decode_thing
from conf.protocol.portrait.patch import Patch
from conf.protocol.portrait.photo import NeutralUpdate, Photograph
from conf.receiver.portrait.decoding import decode_picture, paint_patch
from conf.receiver.portrait.inpainting import person_share
from conf.receiver.portrait.matting import Cutout, cut_out

MAX_EARLY = 15


@dataclass(frozen=True)
class Sitter:
    """A photograph that is ready to be moved.

    pixels : (H, W, 3) uint8 BGR, as they came
    """

    number: int
    pixels: NDArray[np.uint8]
    cutout: Cutout
    warp: PortraitWarp


@dataclass(frozen=True)
class Sticker:
    """A patch that is ready to be laid on.

    keys : (k,) float64; points : (m, 2) 0 to 1 from the upper left corner; pixels : (h, w, 3) uint8 BGR
    """

    keys: NDArray[np.float64]
    points: NDArray[np.float64]
    pixels: NDArray[np.uint8]


class Album:
    """Takes the objects as they arrive. Whatever is wrong with one is refused and counted; the call goes on."""

    def __init__(self) -> None:
        self.refused = 0
        self.sitter: Sitter | None = None
        self.stickers: dict[tuple[int, int], Sticker] = {}  # by region and slot
        self._early: list[Patch | NeutralUpdate] = []  # what belongs to a photograph that has not come yet

    def receive(self, data: bytes, /) -> bool:
        """Take the bytes of an object that is whole; return whether they were good."""
        try:
            thing = decode_thing(data)
            match thing:
                case Photograph():
                    self._take_photograph(thing)
                case NeutralUpdate():
                    self._take_neutral(thing)
                case Patch():
                    self._take_patch(thing)
        except ProtocolError:
            self.refused += 1
            return False
        return True

    def _take_photograph(self, photo: Photograph) -> None:
        pixels = decode_picture(photo.frame)
        person = person_share(photo.outline, (pixels.shape[1], pixels.shape[0]))
        shape = FaceShape.of_photograph(photo.size, photo.pose, photo.points, photo.neutral, photo.fapu, photo.outline)
        try:
            warp = PortraitWarp(shape)
        except (ValueError, QhullError) as error:  # points that all coincide, or lie where no mesh can be
            raise ProtocolError(f"a face that cannot be moved: {error}") from error
        self.sitter = Sitter(photo.number, pixels, cut_out(pixels, person), warp)
        self.stickers.clear()
        early, self._early = self._early, []
        for thing in early:
            if thing.photograph == photo.number:
                self._take_early(thing)

    def _take_early(self, thing: Patch | NeutralUpdate) -> None:
        if isinstance(thing, Patch):
            self._take_patch(thing)
        else:
            self._take_neutral(thing)

    def _take_neutral(self, update: NeutralUpdate) -> None:
        if self.sitter is None or self.sitter.number != update.photograph:
            self._early = [*self._early[-MAX_EARLY:], update]
            return
        self.sitter.warp.follow_neutral(update.neutral, Fapu(*update.fapu).lengths())

    def _take_patch(self, patch: Patch) -> None:
        if self.sitter is None or self.sitter.number != patch.photograph:
            self._early = [*self._early[-MAX_EARLY:], patch]
            return
        try:
            pixels = paint_patch(patch, self.sitter.pixels, self.sitter.warp)
        except ValueError as error:  # points that all coincide
            raise ProtocolError(f"a patch that cannot be laid on: {error}") from error
        self.stickers[patch.region, patch.slot] = Sticker(patch.keys.astype(np.float64), patch.points, pixels)
