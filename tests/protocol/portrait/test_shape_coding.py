import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.portrait.probability_model import PortraitModel, Steps, load_portrait_model
from conf.protocol.portrait.shape_coding import (
    decode_neutral_shape,
    decode_shape,
    encode_neutral_shape,
    encode_shape,
)


@pytest.fixture
def model() -> PortraitModel:
    return load_portrait_model()


def face(model: PortraitModel, noise: int) -> tuple[Steps, Steps, Steps]:
    rng = np.random.default_rng(5)
    points = model.face.mean + rng.integers(-noise, noise + 1, model.face.mean.shape)
    neutral = points[: len(model.neutral_difference_scale)] + rng.integers(
        -noise, noise + 1, (len(model.neutral_difference_scale), 3)
    )
    return points, neutral, rng.integers(0, 256, (40, 2))


@pytest.mark.parametrize("noise", [0, 3, 30, 2000])
def test_every_number_comes_back(model: PortraitModel, noise: int) -> None:
    sent = face(model, noise)
    got = decode_shape(encode_shape(*sent, model), len(sent[2]), model)
    for mine, theirs in zip(sent, got, strict=True):
        np.testing.assert_array_equal(theirs, mine)
    np.testing.assert_array_equal(decode_neutral_shape(encode_neutral_shape(sent[1], model), model), sent[1])


def test_a_face_that_is_wider_and_taller_than_the_average_costs_little(model: PortraitModel) -> None:
    points = np.rint(model.face.mean * (1.05, 0.96, 1.03)).astype(np.int64)
    data = encode_shape(points, points[: len(model.neutral_difference_scale)], np.zeros((0, 2), np.int64), model)
    assert len(data) < 1.6 * len(model.face.mean), "one byte a coordinate would be three times that"


def test_whatever_the_bytes_they_are_a_face_of_so_many_points_or_refused(model: PortraitModel) -> None:
    rng = np.random.default_rng(7)
    good = encode_shape(*face(model, 3), model)
    refused = 0
    for length in (0, 1, 30, len(good), 2000):
        for _ in range(20):
            try:
                points, neutral, outline = decode_shape(rng.bytes(length), 40, model)
            except ProtocolError:
                refused += 1
            else:
                assert (len(points), len(neutral), len(outline)) == (
                    len(model.face.mean),
                    len(model.neutral_difference_scale),
                    40,
                )
    assert refused
    with pytest.raises(ProtocolError):
        decode_shape(good + b"\1", 40, model)
