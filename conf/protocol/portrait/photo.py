"""The photo: one VP8 frame and the numbers with which 50 control points animate it."""

from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.portrait.probability_model import Steps, load_portrait_model
from conf.protocol.portrait.shape_coding import (
    OUTLINE_STEPS,
    POINT_STEP,
    decode_neutral_shape,
    decode_shape,
    encode_neutral_shape,
    encode_shape,
)
from conf.protocol.portrait.vp8 import read_frame_size

POSE_STEP = 5e-4  # radians, image heights, log
FAPU_STEP = 1e-3  # cm
MAX_OUTLINE = 64  # points
MAX_CM = 60.0
# 1 cm is a hundredth of the image height: the mesh of a smaller face would need too many triangles.
MIN_LOG_SCALE = -4.6


@dataclass(frozen=True)
class Photo:
    """A photo of the person.

    number : modulo 256; patches and neutral poses refer to it
    size : width and height in pixels of the image that it was cut from
    pose : (6,) of the head, as in MotionFrame
    points : (D, 3) cm in face axes: first the n control points, then the contours
    neutral : (n, 3) cm in face axes: the control points of the neutral pose
    fapu : five distances of the neutral pose, cm
    outline : (K, 2) of the person, 0 to 1 from the image's upper left corner; empty: everything is person
    frame : the bare VP8 frame of the whole image
    """

    number: int
    size: tuple[int, int]
    pose: NDArray[np.float64]
    points: NDArray[np.float64]
    neutral: NDArray[np.float64]
    fapu: tuple[float, ...]
    outline: NDArray[np.float64]
    frame: bytes


@dataclass(frozen=True)
class NeutralPoseUpdate:
    """A better estimate of the neutral pose of a photo that was sent before.

    neutral : (n, 3) cm; fapu : five distances, cm
    """

    photo_number: int
    neutral: NDArray[np.float64]
    fapu: tuple[float, ...]


def encode_photo(photo: Photo, /) -> bytes:
    """Return the bytes of a photo."""
    numbers = [photo.number, *photo.size, len(photo.outline)]
    numbers += [round(value) for value in photo.pose / POSE_STEP] + _fapu_steps(photo.fapu)
    outline = np.clip(np.rint(photo.outline * OUTLINE_STEPS), 0, OUTLINE_STEPS).astype(np.int64)
    shape = encode_shape(to_point_steps(photo.points), to_point_steps(photo.neutral), outline, load_portrait_model())
    return bytes(msgpack.packb([numbers, shape, photo.frame]))


def decode_photo(data: bytes, /) -> Photo:
    """Return the photo. Raises ProtocolError."""
    values, shape, frame = unpack_fields(data, 15, 2)
    number, width, height, outline_points = values[:4]
    if not (0 <= number < 256 and 16 <= width <= 8192 and 16 <= height <= 8192 and width <= 4 * height <= 16 * width):
        raise ProtocolError("a photo of an impossible size")
    if not 0 <= outline_points <= MAX_OUTLINE:
        raise ProtocolError("an outline with too many points")
    read_frame_size(frame)
    points, neutral, outline = decode_shape(shape, outline_points, load_portrait_model())
    if outline.size and not 0 <= outline.min() <= outline.max() <= OUTLINE_STEPS:
        raise ProtocolError("an outline outside the image")
    pose = np.array(values[4:10]) * POSE_STEP
    check_pose(pose)
    centimetres = to_centimetres(points), to_centimetres(neutral)
    return Photo(number, (width, height), pose, *centimetres, _fapu(values[10:]), outline / OUTLINE_STEPS, frame)


def encode_neutral(update: NeutralPoseUpdate, /) -> bytes:
    """Return the bytes of a neutral pose."""
    shape = encode_neutral_shape(to_point_steps(update.neutral), load_portrait_model())
    return bytes(msgpack.packb([[update.photo_number, *_fapu_steps(update.fapu)], shape]))


def decode_neutral(data: bytes, /) -> NeutralPoseUpdate:
    """Return the neutral pose. Raises ProtocolError."""
    (photo_number, *fapu), shape = unpack_fields(data, 6, 1)
    if not 0 <= photo_number < 256:
        raise ProtocolError("a neutral pose with an invalid photo number")
    neutral = decode_neutral_shape(shape, load_portrait_model())
    return NeutralPoseUpdate(photo_number, to_centimetres(neutral), _fapu(fapu))


def check_pose(pose: NDArray[np.float64], /) -> None:
    """Raise ProtocolError if no head has the pose (6,)."""
    if np.abs(pose[:3]).max() > 7 or np.abs(pose[3:5]).max() > 4 or not MIN_LOG_SCALE <= pose[5] < 1:
        raise ProtocolError("an impossible head pose")


def unpack_fields(data: bytes, numbers: int, strings: int) -> list[Any]:
    """Return a list of so many integers, then so many byte strings. Raises ProtocolError."""
    try:
        fields = msgpack.unpackb(data, max_array_len=32, max_map_len=0, max_ext_len=0, max_str_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("not msgpack") from error
    if type(fields) is not list or len(fields) != 1 + strings or any(type(f) is not bytes for f in fields[1:]):
        raise ProtocolError(f"not {1 + strings} fields")
    if type(fields[0]) is not list or len(fields[0]) != numbers:
        raise ProtocolError(f"not {numbers} numbers")
    if any(type(n) is not int or abs(n) >= 1 << 31 for n in fields[0]):
        raise ProtocolError("a field is not a small integer")
    return fields


def to_point_steps(points: NDArray[np.float64]) -> Steps:
    """Return points in cm as steps of POINT_STEP."""
    return np.rint(points / POINT_STEP).astype(np.int64)


def to_centimetres(steps: Steps) -> NDArray[np.float64]:
    """Return points in steps of POINT_STEP as cm. Raises ProtocolError if no face is that large."""
    points = steps * POINT_STEP
    if np.abs(points).max() > MAX_CM:
        raise ProtocolError(f"a face larger than {MAX_CM:g} cm")
    return np.asarray(points)


def _fapu_steps(fapu: tuple[float, ...]) -> list[int]:
    return [round(distance / FAPU_STEP) for distance in fapu]


def _fapu(steps: list[int]) -> tuple[float, ...]:
    if not all(0 < step <= 0xFFFF for step in steps):
        raise ProtocolError("a FAPU distance out of range")
    return tuple(step * FAPU_STEP for step in steps)
