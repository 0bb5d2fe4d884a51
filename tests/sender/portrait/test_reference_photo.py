import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH
from conf.protocol.portrait.objects import encode_object
from conf.sender.portrait.reference_photo import ReferencePhoto, patch_residual
from tests.support.portrait_subjects import (
    build_photo,
    captured_face,
    landmarks,
    motion,
    recent_frame,
    shaded_person,
    with_hand,
)
from tests.support.synthetic_portrait import POSE

FACE = captured_face(shaded_person())


@pytest.fixture(scope="module")
def reference() -> ReferencePhoto:
    return ReferencePhoto.from_bytes(encode_object(build_photo(FACE)), FACE)


@pytest.mark.slow
def test_decoding_and_encoding_again_gives_the_same_bytes(reference: ReferencePhoto) -> None:
    assert encode_object(reference.photo) == encode_object(build_photo(FACE))


def test_a_face_as_in_the_photo_can_be_patched_and_a_turned_one_cannot(reference: ReferencePhoto) -> None:
    turned = HeadPose(POSE.rotation + np.array((0, 0.6, 0)), POSE.position, POSE.log_scale)
    for region in range(len(FEATURES)):
        assert reference.can_patch(recent_frame(FACE.pixels), region)
        assert not reference.can_patch(recent_frame(FACE.pixels, motion(pose=turned)), region)


def test_a_hand_covers_the_mouth_but_not_the_eyes(reference: ReferencePhoto) -> None:
    hand = recent_frame(with_hand())
    assert reference.is_covered(hand) and not reference.is_covered(recent_frame(FACE.pixels))
    assert [reference.can_patch(hand, FEATURES.index(feature)) for feature in (MOUTH, EYES)] == [False, True]


@pytest.mark.parametrize("light", [1.0, 0.7])
def test_the_residual_of_the_photographed_face_is_small_in_any_light(reference: ReferencePhoto, light: float) -> None:
    residual, points = patch_residual(reference, recent_frame(shaded_person(light)), MOUTH)
    assert np.abs(residual).mean() < 5
    assert points.shape == (len(MOUTH.points), 2)


def test_a_painted_mouth_has_a_residual_there_and_none_at_the_border(reference: ReferencePhoto) -> None:
    painted = shaded_person()
    x, y = landmarks()[13, :2].astype(int)
    painted[y - 3 : y + 4, x - 6 : x + 7] = (255, 255, 255)
    residual, _ = patch_residual(reference, recent_frame(painted), MOUTH)
    height, width = residual.shape[:2]
    middle = residual[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3]
    assert middle.max() > 60 and np.abs(residual[0]).max() == 0
