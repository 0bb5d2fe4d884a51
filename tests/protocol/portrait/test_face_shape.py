import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait import contours
from conf.protocol.portrait.face_shape import (
    FaceModel,
    Steps,
    decode_neutral_shape,
    decode_shape,
    encode_neutral_shape,
    encode_shape,
    load_face_model,
)


@pytest.fixture
def model() -> FaceModel:
    return load_face_model()


def face(model: FaceModel, noise: int) -> tuple[Steps, Steps, Steps]:
    rng = np.random.default_rng(5)
    points = model.mean + rng.integers(-noise, noise + 1, model.mean.shape)
    neutral = points[: model.control_count] + rng.integers(-noise, noise + 1, (model.control_count, 3))
    return points, neutral, rng.integers(0, 256, (40, 2))


@pytest.mark.parametrize("noise", [0, 3, 30, 2000])
def test_every_number_comes_back(model: FaceModel, noise: int) -> None:
    sent = face(model, noise)
    got = decode_shape(encode_shape(*sent, model), len(sent[2]), model)
    for mine, theirs in zip(sent, got, strict=True):
        np.testing.assert_array_equal(theirs, mine)
    np.testing.assert_array_equal(decode_neutral_shape(encode_neutral_shape(sent[1], model), model), sent[1])


def test_a_face_that_is_wider_and_taller_than_the_average_costs_little(model: FaceModel) -> None:
    points = np.rint(model.mean * (1.05, 0.96, 1.03)).astype(np.int64)
    data = encode_shape(points, points[: model.control_count], np.zeros((0, 2), np.int64), model)
    assert len(data) < 1.6 * model.point_count, "one byte a coordinate would be three times that"


def test_the_model_has_the_points_that_both_sides_use(model: FaceModel) -> None:
    assert (model.point_count, model.control_count) == (len(contours.ALL), CONTROL_POINT_COUNT)
    assert sorted(model.order) == list(range(model.point_count))
    assert sorted(model.order[: model.control_count]) == list(range(model.control_count)), "alone"
    assert model.parents[0] == -1 and all(0 <= model.parents[i] < i for i in range(1, model.point_count))


def test_whatever_the_bytes_they_are_a_face_of_so_many_points_or_refused(model: FaceModel) -> None:
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
                assert (len(points), len(neutral), len(outline)) == (model.point_count, model.control_count, 40)
    assert refused
    with pytest.raises(ProtocolError):
        decode_shape(good + b"\1", 40, model)
