"""The photograph as it travels: one VP8 frame and the numbers that let fifty points move it."""

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

POSE_STEPS = np.array([5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4])  # radians, picture heights, log
FAPU_STEP = 1e-3  # cm
MAX_OUTLINE = 64
MAX_CM = 60.0
MIN_LOG_SCALE = -4.6  # a hundredth of the picture for a centimetre: a mesh fine enough for a smaller face is huge


@dataclass(frozen=True)
class Photo:
    """A picture of the person.

    number : which photograph this is, modulo 256: patches belong to one
    size : width and height in pixels of the picture it was taken from
    pose : (6,) of the head in it, as in MotionFrame
    points : (D, 3) cm in face axes: first the n control points, then the outlines
    neutral : (n, 3) cm in face axes: the control points of the neutral pose
    fapu : five distances of the neutral pose, cm
    outline : (K, 2) of the person, 0 to 1 from the picture's upper left corner; none: everything is person
    frame : the bare VP8 frame, of the whole picture
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
    """A better estimate of the neutral pose, for a photograph that is already there.

    photograph : its number
    neutral : (n, 3) cm; fapu : five distances, cm
    """

    photo_number: int
    neutral: NDArray[np.float64]
    fapu: tuple[float, ...]


def encode_photo(photo: Photo, /) -> bytes:
    """Return the bytes of a photograph."""
    numbers = [photo.number, *photo.size, len(photo.outline)]
    numbers += [round(value) for value in photo.pose / POSE_STEPS] + _fapu_steps(photo.fapu)
    outline = np.clip(np.rint(photo.outline * OUTLINE_STEPS), 0, OUTLINE_STEPS).astype(np.int64)
    shape = encode_shape(_point_steps(photo.points), _point_steps(photo.neutral), outline, load_portrait_model())
    return _pack([numbers, shape, photo.frame])


def decode_photo(data: bytes, /) -> Photo:
    """Return the photograph. Raises ProtocolError."""
    numbers, shape, frame = _unpack(data, 3)
    values = check_numbers(numbers, 15)
    number, width, height, corners = values[:4]
    if not (0 <= number < 256 and 16 <= width <= 8192 and 16 <= height <= 8192 and width <= 4 * height <= 16 * width):
        raise ProtocolError("a photograph of an impossible size")
    if not 0 <= corners <= MAX_OUTLINE:
        raise ProtocolError("an outline with too many corners")
    read_frame_size(frame)
    points, neutral, outline = decode_shape(shape, corners, load_portrait_model())
    if outline.size and not 0 <= outline.min() <= outline.max() <= OUTLINE_STEPS:
        raise ProtocolError("an outline outside the picture")
    return Photo(
        number,
        (width, height),
        check_pose(np.array(values[4:10]) * POSE_STEPS),
        _within(points * POINT_STEP),
        _within(neutral * POINT_STEP),
        _fapu(values[10:]),
        outline / OUTLINE_STEPS,
        frame,
    )


def encode_neutral(update: NeutralPoseUpdate, /) -> bytes:
    """Return the bytes of a neutral pose."""
    shape = encode_neutral_shape(_point_steps(update.neutral), load_portrait_model())
    return _pack([[update.photo_number, *_fapu_steps(update.fapu)], shape])


def decode_neutral(data: bytes, /) -> NeutralPoseUpdate:
    """Return the neutral pose. Raises ProtocolError."""
    numbers, shape = _unpack(data, 2)
    photograph, *fapu = check_numbers(numbers, 6)
    if not 0 <= photograph < 256:
        raise ProtocolError("a neutral pose of no photograph")
    neutral = decode_neutral_shape(shape, load_portrait_model())
    return NeutralPoseUpdate(photograph, _within(neutral * POINT_STEP), _fapu(fapu))


def check_pose(pose: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return a pose (6,) that can be drawn. Raises ProtocolError."""
    if np.abs(pose[:3]).max() > 7 or np.abs(pose[3:5]).max() > 4 or not MIN_LOG_SCALE <= pose[5] < 1:
        raise ProtocolError("a pose that no head has")
    return pose


def check_numbers(numbers: Any, count: int, /) -> list[int]:
    """Return a list of exactly `count` integers. Raises ProtocolError."""
    if type(numbers) is not list or len(numbers) != count:
        raise ProtocolError(f"not {count} numbers")
    if any(type(n) is not int or abs(n) >= 1 << 31 for n in numbers):
        raise ProtocolError("a field is not a small integer")
    return numbers


def _pack(fields: list[Any]) -> bytes:
    data: bytes = msgpack.packb(fields)
    return data


def _unpack(data: bytes, count: int) -> list[Any]:
    """Return the fields: a list of numbers, then byte strings. Raises ProtocolError."""
    try:
        fields = msgpack.unpackb(data, max_array_len=32, max_map_len=0, max_ext_len=0, max_str_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("not msgpack") from error
    if type(fields) is not list or len(fields) != count or any(type(f) is not bytes for f in fields[1:]):
        raise ProtocolError(f"not {count} fields")
    return fields


def _point_steps(points: NDArray[np.float64]) -> Steps:
    return np.rint(points / POINT_STEP).astype(np.int64)


def _within(points: NDArray[np.floating]) -> NDArray[np.float64]:
    if np.abs(points).max() > MAX_CM:
        raise ProtocolError("a face larger than any")
    return np.asarray(points, dtype=np.float64)


def _fapu_steps(fapu: tuple[float, ...]) -> list[int]:
    return [round(distance / FAPU_STEP) for distance in fapu]


def _fapu(steps: list[int]) -> tuple[float, ...]:
    if not all(0 < step <= 0xFFFF for step in steps):
        raise ProtocolError("a FAPU distance out of range")
    return tuple(step * FAPU_STEP for step in steps)
