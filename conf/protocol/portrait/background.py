"""The background: what the person in the photo covered, as the camera saw it later.

One msgpack array of two elements: integers (number of the photo, left, top, right and bottom of the image in 1/255 of
the photo), and the bare VP8 frame.
"""

from dataclasses import dataclass

import msgpack

from conf.errors import ProtocolError
from conf.protocol.portrait.image_box import Box, box_from_steps, box_to_steps
from conf.protocol.portrait.photo import unpack_fields
from conf.protocol.portrait.vp8 import read_frame_size


@dataclass(frozen=True)
class Background:
    """A part of the background of a photo. It replaces the one before.

    photo_number : of the photo that it belongs to
    box : of the image in the photo
    frame : the bare VP8 frame of the image
    """

    photo_number: int
    box: Box
    frame: bytes


def encode_background(background: Background, /) -> bytes:
    """Return the bytes of a background."""
    numbers = [background.photo_number, *box_to_steps(background.box)]
    return bytes(msgpack.packb([numbers, background.frame]))


def decode_background(data: bytes, /) -> Background:
    """Return the background. Raises ProtocolError."""
    numbers, frame = unpack_fields(data, 5, 1)
    if not 0 <= numbers[0] < 256:
        raise ProtocolError("a background with an invalid photo number")
    box = box_from_steps(numbers[1:], "photo")
    read_frame_size(frame)
    return Background(numbers[0], box, frame)
