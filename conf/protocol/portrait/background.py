"""The background: what the person in the photo covered, as the camera saw it later.

One msgpack array of two elements: integers (number of the photo, left, top, right and bottom of the image in 1/255 of
the photo), and the bare VP8 frame.
"""

from dataclasses import dataclass

import msgpack

from conf.errors import ProtocolError
from conf.protocol.portrait.photo import unpack_fields
from conf.protocol.portrait.view import BOX_STEPS
from conf.protocol.portrait.vp8 import read_frame_size


@dataclass(frozen=True)
class Background:
    """A part of the background of a photo. It replaces the one before.

    photo_number : of the photo that it belongs to
    box : left, top, right and bottom of the image in the photo, 0 to 1 from the upper left corner
    frame : the bare VP8 frame of the image
    """

    photo_number: int
    box: tuple[float, float, float, float]
    frame: bytes


def encode_background(background: Background, /) -> bytes:
    """Return the bytes of a background."""
    numbers = [background.photo_number, *(round(side * BOX_STEPS) for side in background.box)]
    return bytes(msgpack.packb([numbers, background.frame]))


def decode_background(data: bytes, /) -> Background:
    """Return the background. Raises ProtocolError."""
    (photo_number, left, top, right, bottom), frame = unpack_fields(data, 5, 1)
    if not 0 <= photo_number < 256:
        raise ProtocolError("a background with an invalid photo number")
    if not (0 <= left < right <= BOX_STEPS and 0 <= top < bottom <= BOX_STEPS):
        raise ProtocolError("a background outside the photo")
    read_frame_size(frame)
    return Background(photo_number, (left / BOX_STEPS, top / BOX_STEPS, right / BOX_STEPS, bottom / BOX_STEPS), frame)
