import numpy as np

from conf.protocol.portrait import decode_object, encode_object
from conf.protocol.portrait.vp8 import read_frame_size
from conf.sender.portrait.photo_builder import DRAFT, FULL, blur_background, build_photo, build_photo_steps
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import canonical, landmarks, shot
from tests.support.synthetic_portrait import POSE, face_points


def test_a_photograph_knows_pose_and_points_of_the_face() -> None:
    photo = build_photo(shot(), canonical(), 3)
    np.testing.assert_allclose(photo.pose, POSE.to_vector(), atol=0.02)
    np.testing.assert_allclose(photo.points, face_points(), atol=0.05)
    assert photo.number == 3 and len(photo.frame) <= FULL.max_bytes and read_frame_size(photo.frame) == (320, 240)
    assert decode_object(encode_object(photo))


def test_it_is_developed_in_a_few_steps() -> None:
    steps = list(build_photo_steps(shot(), canonical(), 0, DRAFT))
    *before, photo = steps
    assert photo is not None and len(photo.frame) <= DRAFT.max_bytes
    assert 2 <= len(before) <= 6 and all(step is None for step in before)


def test_a_large_picture_is_made_smaller() -> None:
    large = np.repeat(np.repeat(draw_person(), 2, axis=0), 2, axis=1)
    big = shot(large)
    photo = build_photo(type(big)(large, landmarks() * 2, big.neutral, big.fapu), canonical(), 0)
    assert photo.size == (640, 480) and read_frame_size(photo.frame) == (320, 240)


def test_the_background_is_softened_and_the_face_is_not() -> None:
    noise = np.random.default_rng(0).normal(0, 20, (240, 320, 3))
    pixels = np.clip(draw_person() + noise, 0, 255).astype(np.uint8)
    outline = np.array([(0.3, 1), (0.35, 0.2), (0.7, 0.2), (0.75, 1)])
    softened = blur_background(pixels, outline, landmarks()[:, :2])
    x, y = landmarks()[4, :2].astype(int)
    corner, nose = (slice(0, 40), slice(0, 40), 0), (slice(y - 10, y + 10), slice(x - 10, x + 10))
    assert softened[corner].std() < 0.6 * pixels[corner].std()
    np.testing.assert_allclose(softened[nose], pixels[nose], atol=1)
