"""A patch as it travels: a small picture of one region of the face, and the moment it belongs to.

photograph u8, region u8, slot u8, keys u8, points u8, keys x i8, points x (u8, u8), VP8 frame
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.portrait.vp8 import size_of

MAX_REGIONS = 4
MAX_SLOTS = 16  # of each region
MAX_KEYS = 16
MAX_POINTS = 64
MAX_SIDE = 256  # px
POINT_STEPS = 127.5  # from one border of the patch to the other
BEYOND = 0.5  # how far outside the patch a point may lie
_HEADER = struct.Struct(">BBBBB")


@dataclass(frozen=True)
class Patch:
    """A picture of a region of the face.

    photograph : number of the photograph that it is laid over
    region : which part of the face
    slot : it replaces what the slot of its region held
    keys : (k,) int8, what the face was doing: the receiver shows the patch whose keys are nearest
    points : (m, 2) the region's control points: 0 to 1 from the patch's upper left corner, a half beyond at most
    frame : the bare VP8 frame
    """

    photograph: int
    region: int
    slot: int
    keys: NDArray[np.int8]
    points: NDArray[np.float64]
    frame: bytes


def encode_patch(patch: Patch, /) -> bytes:
    """Return the bytes of a patch."""
    header = _HEADER.pack(patch.photograph, patch.region, patch.slot, len(patch.keys), len(patch.points))
    points = np.clip(np.rint((patch.points + BEYOND) * POINT_STEPS), 0, 255).astype(np.uint8)
    return header + patch.keys.astype(np.int8).tobytes() + points.tobytes() + patch.frame


def decode_patch(data: bytes, /) -> Patch:
    """Return the patch. Raises ProtocolError."""
    if len(data) < _HEADER.size:
        raise ProtocolError("a patch cut off")
    photograph, region, slot, keys, points = _HEADER.unpack_from(data)
    if region >= MAX_REGIONS or slot >= MAX_SLOTS or not 0 < keys <= MAX_KEYS or not 3 <= points <= MAX_POINTS:
        raise ProtocolError("a patch for no region or slot")
    at = _HEADER.size + keys
    end = at + 2 * points
    frame = data[end:]
    if max(size_of(frame)) > MAX_SIDE:
        raise ProtocolError("a patch that is too large")
    return Patch(
        photograph,
        region,
        slot,
        np.frombuffer(data, np.int8, keys, _HEADER.size),
        np.frombuffer(data, np.uint8, 2 * points, at).reshape(-1, 2) / POINT_STEPS - BEYOND,
        frame,
    )
