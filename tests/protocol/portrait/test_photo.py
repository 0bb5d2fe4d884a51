"""The photo and the neutral pose: precision, limits and errors."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import msgpack
import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.portrait.photo import NeutralPoseUpdate, decode_neutral, decode_photo, encode_neutral, encode_photo
from tests.support.portrait_objects import example_photo

PHOTO = example_photo()
FIELDS = msgpack.unpackb(encode_photo(PHOTO))
UPDATE = NeutralPoseUpdate(7, PHOTO.neutral, (6.4, 5.0, 2.5, 5.2, 0.9))
UPDATE_FIELDS = msgpack.unpackb(encode_neutral(UPDATE))


def with_number(fields: list[Any], index: int, value: object) -> bytes:
    """Return an object with one of its integers replaced."""
    numbers = list(fields[0])
    numbers[index] = value
    data: bytes = msgpack.packb([numbers, *fields[1:]])
    return data


def test_a_photo_is_decoded_within_its_steps() -> None:
    decoded = decode_photo(encode_photo(PHOTO))
    np.testing.assert_allclose(decoded.points, PHOTO.points, atol=0.01 + 1e-9)
    np.testing.assert_allclose(decoded.neutral, PHOTO.neutral, atol=0.01 + 1e-9)
    np.testing.assert_allclose(decoded.pose, PHOTO.pose, atol=2.5e-4 + 1e-9)
    np.testing.assert_allclose(decoded.outline, PHOTO.outline, atol=0.5 / 255 + 1e-9)
    assert (decoded.number, decoded.size, decoded.frame) == (PHOTO.number, PHOTO.size, PHOTO.frame)
    assert decoded.fapu == pytest.approx(PHOTO.fapu)


def test_the_integers_of_a_photo_are_those_of_wire_md() -> None:
    assert FIELDS[0] == [1, 320, 240, 30, 200, -400, 100, 40, -200, -6800, 6400, 5000, 2500, 5200, 900]
    assert UPDATE_FIELDS[0] == [7, 6400, 5000, 2500, 5200, 900]


def test_a_neutral_pose_is_decoded_within_its_steps() -> None:
    decoded = decode_neutral(encode_neutral(UPDATE))
    np.testing.assert_allclose(decoded.neutral, UPDATE.neutral, atol=0.01 + 1e-9)
    assert decoded.photo_number == 7 and decoded.fapu == pytest.approx(UPDATE.fapu)


def test_outline_points_outside_the_image_are_moved_to_its_border() -> None:
    outline = np.array([[-0.5, 0.5], [1.5, 1.0], [0.0, 2.0]])
    decoded = decode_photo(encode_photo(replace(PHOTO, outline=outline)))
    np.testing.assert_allclose(decoded.outline, np.clip(outline, 0, 1), atol=0.002)
    assert decode_photo(encode_photo(replace(PHOTO, outline=np.zeros((0, 2))))).outline.shape == (0, 2)


# Index of the integer, accepted values, rejected values, error.
SIZE = "a photo of an impossible size"
POSE = "an impossible head pose"
LIMITS: list[tuple[int, list[int], list[int], str]] = [
    (0, [0, 255], [-1, 256], SIZE),
    (1, [60, 960], [59, 961, 15], SIZE),
    (2, [80, 1280], [79, 1281], SIZE),
    (4, [0, 14000, -14000], [14001, -14001], POSE),
    (6, [14000], [14001], POSE),
    (7, [8000, -8000], [8001, -8001], POSE),
    (8, [8000], [-8001], POSE),
    (9, [-9199, 1999], [-9201, 2000], POSE),
    (10, [1, 65535], [0, -1, 65536], "a FAPU distance out of range"),
    (14, [1], [0], "a FAPU distance out of range"),
]
CASES = [
    (index, value, error if value in rejected else None)
    for index, accepted, rejected, error in LIMITS
    for value in accepted + rejected
]


@pytest.mark.parametrize(("index", "value", "error"), CASES)
def test_the_integers_of_a_photo_have_limits(index: int, value: int, error: str | None) -> None:
    with pytest.raises(ProtocolError, match=error) if error else nullcontext():
        decode_photo(with_number(FIELDS, index, value))


@pytest.mark.parametrize(
    ("size", "valid"),
    [
        ((16, 16), True),
        ((15, 16), False),
        ((16, 15), False),
        ((8192, 8192), True),
        ((8193, 8192), False),
        ((8192, 8193), False),
    ],
)
def test_the_size_of_a_photo_has_limits(size: tuple[int, int], valid: bool) -> None:
    data = encode_photo(replace(PHOTO, size=size))
    with nullcontext() if valid else pytest.raises(ProtocolError, match=SIZE):
        decode_photo(data)


@pytest.mark.parametrize(("scale", "valid"), [(60.0, True), (60.1, False)])
@pytest.mark.parametrize("field", ["points", "neutral"])
def test_a_face_of_more_than_60_cm_is_rejected(field: str, scale: float, valid: bool) -> None:
    points = getattr(PHOTO, field)
    photo = replace(PHOTO, **{field: points / np.abs(points).max() * scale})
    with nullcontext() if valid else pytest.raises(ProtocolError, match="a face larger than 60 cm"):
        decode_photo(encode_photo(photo))


@pytest.mark.parametrize(("points", "valid"), [(0, True), (64, True), (65, False)])
def test_an_outline_has_at_most_64_points(points: int, valid: bool) -> None:
    data = encode_photo(replace(PHOTO, outline=np.full((points, 2), 0.5)))
    with nullcontext() if valid else pytest.raises(ProtocolError, match="an outline with too many points"):
        decode_photo(data)
    if not points:
        with pytest.raises(ProtocolError, match="an outline with too many points"):
            decode_photo(with_number(FIELDS, 3, -1))


@pytest.mark.parametrize("value", [(-1 / 255, 0.5), (0.5, 256 / 255)])
def test_an_outline_outside_the_image_is_rejected(value: tuple[float, float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.protocol.portrait.photo.np.clip", lambda array, low, high: array)
    with pytest.raises(ProtocolError, match="an outline outside the image"):
        decode_photo(encode_photo(replace(PHOTO, outline=np.array([value]))))


def test_the_frame_of_a_photo_is_checked() -> None:
    with pytest.raises(ProtocolError, match="not a VP8 key frame"):
        decode_photo(encode_photo(replace(PHOTO, frame=b"?")))


@pytest.mark.parametrize(
    ("index", "value", "valid"), [(0, 0, True), (0, 255, True), (0, -1, False), (0, 256, False), (1, 0, False)]
)
def test_the_integers_of_a_neutral_pose_have_limits(index: int, value: int, valid: bool) -> None:
    error = "invalid photo number" if index == 0 else "a FAPU distance out of range"
    with nullcontext() if valid else pytest.raises(ProtocolError, match=error):
        decode_neutral(with_number(UPDATE_FIELDS, index, value))


@pytest.mark.parametrize("decode", [decode_photo, decode_neutral])
@pytest.mark.parametrize(
    ("data", "error"),
    [
        (b"\xc1", "not msgpack"),
        (msgpack.packb({}), "fields"),
        *((msgpack.packb(value), "not msgpack") for value in ("a", {1: 1}, msgpack.ExtType(1, b"a"))),
        (msgpack.packb([[1] * 33]), "not msgpack"),
        (msgpack.packb([[]]), "fields"),
        (msgpack.packb([[], 1, 2]), "fields"),
        (msgpack.packb([[], b"", b"", b""]), "fields"),
    ],
)
def test_other_data_is_rejected(decode: Callable[[bytes], object], data: bytes, error: str) -> None:
    with pytest.raises(ProtocolError, match=error):
        decode(data)


def test_the_fields_after_the_first_are_strings() -> None:
    examples: list[list[object]] = [[1, b"x"], [b"x", 1], [b"x"], [b"x", b"x", b"x"]]
    for strings in examples:
        with pytest.raises(ProtocolError, match="not 3 fields"):
            decode_photo(msgpack.packb([FIELDS[0], *strings]))
    examples = [[1], [], [b"x", b"x"]]
    for strings in examples:
        with pytest.raises(ProtocolError, match="not 2 fields"):
            decode_neutral(msgpack.packb([UPDATE_FIELDS[0], *strings]))


@pytest.mark.parametrize(
    ("numbers", "error"),
    [
        ([1] * 14, "not 15 numbers"),
        ([1] * 16, "not 15 numbers"),
        (b"15 numbers", "not 15 numbers"),
        ([*[1] * 14, 1.0], "not a small integer"),
        ([*[1] * 14, True], "not a small integer"),
        ([1 << 31, *[1] * 14], "not a small integer"),
        ([-(1 << 31), *[1] * 14], "not a small integer"),
        ([(1 << 31) - 1, *[1] * 14], SIZE),
    ],
)
def test_the_first_field_is_15_small_integers(numbers: object, error: str) -> None:
    with pytest.raises(ProtocolError, match=error):
        decode_photo(msgpack.packb([numbers, *FIELDS[1:]]))
