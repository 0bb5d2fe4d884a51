"""The view: the head in another pose or expression than the photo's, as a cropped image for the same mesh.

One msgpack array of three elements: integers (number of the photo, slot, left, top, right and bottom of the image in
1/255 of the frame, pose x 6), the string of the control points, and the bare VP8 frame.
"""

from dataclasses import dataclass

import msgpack
import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.portrait.image_box import Box, box_from_steps, box_to_steps
from conf.protocol.portrait.photo import POSE_STEP, check_pose, to_centimetres, to_point_steps, unpack_fields
from conf.protocol.portrait.probability_model import load_portrait_model
from conf.protocol.portrait.shape_coding import decode_neutral_shape, encode_neutral_shape
from conf.protocol.portrait.vp8 import read_frame_size

MAX_VIEWS = 3  # of each photo


@dataclass(frozen=True)
class View:
    """A view of a photographed person.

    photo_number : of the photo that it belongs to
    slot : it replaces the view in this slot, 0 to MAX_VIEWS - 1
    pose : (6,) of the head, as in MotionFrame
    points : (n, 3) cm in face axes: the control points
    box : of the image in its frame
    frame : the bare VP8 frame of the image
    """

    photo_number: int
    slot: int
    pose: NDArray[np.float64]
    points: NDArray[np.float64]
    box: Box
    frame: bytes


def encode_view(view: View, /) -> bytes:
    """Return the bytes of a view. Raises ValueError if the slot is invalid."""
    if not 0 <= view.slot < MAX_VIEWS:
        raise ValueError(f"there is no slot {view.slot} for a view")
    numbers = [view.photo_number, view.slot, *box_to_steps(view.box)]
    numbers += [round(value) for value in view.pose / POSE_STEP]
    shape = encode_neutral_shape(to_point_steps(view.points), load_portrait_model())
    return bytes(msgpack.packb([numbers, shape, view.frame]))


def decode_view(data: bytes, /) -> View:
    """Return the view. Raises ProtocolError."""
    values, shape, frame = unpack_fields(data, 12, 2)
    photo_number, slot = values[:2]
    if not (0 <= photo_number < 256 and 0 <= slot < MAX_VIEWS):
        raise ProtocolError("a view with an invalid photo number or slot")
    box = box_from_steps(values[2:6], "frame")
    read_frame_size(frame)
    pose = np.array(values[6:]) * POSE_STEP
    check_pose(pose)
    points = to_centimetres(decode_neutral_shape(shape, load_portrait_model()))
    return View(photo_number, slot, pose, points, box, frame)
