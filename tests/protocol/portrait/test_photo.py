from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.portrait.photo import (
    MIN_LOG_SCALE,
    POINT_STEP,
    NeutralPoseUpdate,
    decode_neutral,
    decode_photo,
    encode_neutral,
    encode_photo,
)
from tests.support.portrait_objects import example_photo


def test_a_photograph_survives_within_its_steps() -> None:
    sent = example_photo()
    got = decode_photo(encode_photo(sent))
    np.testing.assert_allclose(got.points, sent.points, atol=POINT_STEP / 2 + 1e-9)
    np.testing.assert_allclose(got.neutral, sent.neutral, atol=POINT_STEP / 2 + 1e-9)
    np.testing.assert_allclose(got.pose, sent.pose, atol=3e-4)
    np.testing.assert_allclose(got.outline, sent.outline, atol=0.002)
    assert (got.number, got.size, got.frame) == (sent.number, sent.size, sent.frame)
    assert got.fapu == pytest.approx(sent.fapu)


def test_a_neutral_pose_survives() -> None:
    sent = NeutralPoseUpdate(7, example_photo().neutral, (6.4, 5.0, 2.5, 5.2, 0.9))
    got = decode_neutral(encode_neutral(sent))
    np.testing.assert_allclose(got.neutral, sent.neutral, atol=POINT_STEP / 2 + 1e-9)
    assert got.photo_number == 7 and got.fapu == pytest.approx(sent.fapu)


def test_what_could_not_be_drawn_is_refused() -> None:
    sent = example_photo()
    wrong = {
        "an impossible head pose": replace(sent, pose=np.array([0, 0, 0, 0, 0, 9.0])),
        "a face larger than 60 cm": replace(sent, points=sent.points * 100),
        "FAPU distance out of range": replace(sent, fapu=(0.0, 1.0, 1.0, 1.0, 1.0)),
        "impossible size": replace(sent, size=(9000, 240)),
        "an outline with too many points": replace(sent, outline=np.zeros((65, 2))),
        "not a VP8 key frame": replace(sent, frame=b"?"),
    }
    for why, photo in wrong.items():
        with pytest.raises(ProtocolError, match=why):
            decode_photo(encode_photo(photo))


def test_a_face_too_small_for_any_mesh_is_refused() -> None:
    for log_scale, good in ((MIN_LOG_SCALE + 0.01, True), (MIN_LOG_SCALE - 0.01, False)):
        data = encode_photo(replace(example_photo(), pose=np.array([0, 0, 0, 0, 0, log_scale])))
        with nullcontext() if good else pytest.raises(ProtocolError, match="an impossible head pose"):
            decode_photo(data)
