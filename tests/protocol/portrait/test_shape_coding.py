"""The string of a photo's shape."""

import numpy as np
import pytest

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
from tests.protocol.independent_decoder import read_shape

MODEL = load_portrait_model()
CONTROL_POINTS = len(MODEL.neutral_difference_scale)


def face(noise: int) -> tuple[Steps, Steps, Steps]:
    """Return points, neutral pose and outline that differ from the mean by up to `noise` steps."""
    rng = np.random.default_rng(5)
    points = MODEL.face.mean + rng.integers(-noise, noise + 1, MODEL.face.mean.shape)
    neutral = points[:CONTROL_POINTS] + rng.integers(-noise, noise + 1, (CONTROL_POINTS, 3))
    return points, neutral, rng.integers(0, 256, (40, 2))


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0, 3, 30, 2000])
def test_both_decoders_read_the_shape_that_was_written(noise: int) -> None:
    sent = face(noise)
    data = encode_shape(*sent, MODEL)
    for decoded in (decode_shape(data, len(sent[2]), MODEL), read_shape(data, len(sent[2]))):
        for expected, array in zip(sent, decoded, strict=True):
            np.testing.assert_array_equal(array, expected)
    np.testing.assert_array_equal(decode_neutral_shape(encode_neutral_shape(sent[1], MODEL), MODEL), sent[1])


def test_steps_are_those_of_wire_md() -> None:
    assert (POINT_STEP, OUTLINE_STEPS) == (0.02, 255)


def test_a_face_wider_and_taller_than_the_mean_costs_few_bytes() -> None:
    points = np.rint(MODEL.face.mean * (1.05, 0.96, 1.03)).astype(np.int64)
    data = encode_shape(points, points[:CONTROL_POINTS], np.zeros((0, 2), np.int64), MODEL)
    assert len(data) < 1.6 * len(MODEL.face.mean), "one byte for each coordinate would be three times the points"


def test_numbers_are_not_changed_to_save_bits() -> None:
    neutral = MODEL.face.mean[:CONTROL_POINTS] + 1
    decoded = decode_neutral_shape(encode_neutral_shape(neutral, MODEL), MODEL)
    np.testing.assert_array_equal(decoded, neutral)


@pytest.mark.slow
def test_any_bytes_give_a_shape_or_protocol_error() -> None:
    rng = np.random.default_rng(7)
    good = encode_shape(*face(3), MODEL)
    rejected = 0
    for length in (0, 1, 30, len(good), 2000):
        for _ in range(20):
            try:
                points, neutral, outline = decode_shape(rng.bytes(length), 40, MODEL)
            except ProtocolError:
                rejected += 1
            else:
                assert (len(points), len(neutral), len(outline)) == (len(MODEL.face.mean), CONTROL_POINTS, 40)
    assert rejected
    with pytest.raises(ProtocolError):
        decode_shape(good + b"\1", 40, MODEL)
    with pytest.raises(ProtocolError):
        decode_neutral_shape(encode_neutral_shape(face(3)[1], MODEL) + b"\1", MODEL)
