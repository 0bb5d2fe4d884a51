from dataclasses import replace

import numpy as np
import pytest

from conf.protocol.portrait.objects import decode_object, encode_object
from conf.protocol.portrait.vp8 import read_frame_size
from conf.sender.portrait.photo_builder import (
    DRAFT,
    FULL,
    PhotoBuilder,
    PhotoQuality,
    blur_background,
    decode_vp8,
    encode_vp8,
)
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import build_photo, canonical, captured_face, landmarks
from tests.support.synthetic_portrait import POSE, face_points


@pytest.mark.slow
def test_a_photo_has_the_pose_and_the_points_of_the_face() -> None:
    photo = build_photo(captured_face(), 3)
    np.testing.assert_allclose(photo.pose, POSE.to_vector(), atol=0.02)
    np.testing.assert_allclose(photo.points, face_points(), atol=0.05)
    assert photo.number == 3 and len(photo.frame) <= FULL.max_bytes and read_frame_size(photo.frame) == (320, 240)
    assert decode_object(encode_object(photo))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quality", "plain_wall", "slices", "size"),
    [
        (DRAFT, True, 1, (256, 192)),  # segmentation by colour takes 1 step, by GrabCut 8; encoding and pose 1 each
        (FULL, True, 3, (320, 240)),
        (DRAFT, False, 4, (256, 192)),
        (FULL, False, 10, (320, 240)),
        (PhotoQuality(3000, 120, 5), False, 2, (160, 120)),
    ],
)
def test_a_photo_is_built_in_time_slices(
    quality: PhotoQuality, plain_wall: bool, slices: int, size: tuple[int, int]
) -> None:
    pixels = draw_person()
    if not plain_wall:
        pixels[:20] = pixels[:, :40] = pixels[:, -40:] = np.random.default_rng(1).integers(0, 255, 3)
        pixels[::2, :40] = pixels[::2, -40:] = 0
        pixels[:20, ::2] = 255
    builder = PhotoBuilder(captured_face(pixels), canonical(), 7, quality)
    *before, photo = [builder.advance() for _ in range(slices)]
    assert before == [None] * (slices - 1) and photo is not None
    assert photo.number == 7 and len(photo.frame) <= quality.max_bytes and read_frame_size(photo.frame) == size
    assert builder.advance() is None


@pytest.mark.slow
def test_a_large_image_is_reduced() -> None:
    large = np.repeat(np.repeat(draw_person(), 2, axis=0), 2, axis=1)
    photo = build_photo(replace(captured_face(large), landmarks=landmarks() * 2))
    assert photo.size == (640, 480) and read_frame_size(photo.frame) == (320, 240)


def test_the_background_is_blurred_and_the_face_is_not() -> None:
    noise = np.random.default_rng(0).normal(0, 20, (240, 320, 3))
    pixels = np.clip(draw_person() + noise, 0, 255).astype(np.uint8)
    outline = np.array([(0.3, 1), (0.35, 0.2), (0.7, 0.2), (0.75, 1)])
    softened = blur_background(pixels, outline, landmarks()[:, :2])
    x, y = landmarks()[4, :2].astype(int)
    corner, nose = (slice(0, 40), slice(0, 40), 0), (slice(y - 10, y + 10), slice(x - 10, x + 10))
    assert softened[corner].std() < 0.6 * pixels[corner].std()
    np.testing.assert_allclose(softened[nose], pixels[nose], atol=1)


@pytest.mark.slow
def test_a_frame_keeps_to_its_bytes_and_more_bytes_give_a_better_image() -> None:
    noisy = draw_person().astype(float) + np.random.default_rng(0).normal(0, 12, (240, 320, 3))
    pixels = np.clip(noisy, 0, 255).astype(np.uint8)
    errors = []
    for max_bytes in (2000, 4000, 8000):
        frame = encode_vp8(pixels, max_bytes=max_bytes)
        assert len(frame) <= max_bytes and read_frame_size(frame) == (320, 240)
        errors.append(float(np.abs(decode_vp8(frame).astype(float) - pixels).mean()))
    assert errors == sorted(errors, reverse=True)


def test_too_few_bytes_give_the_smallest_frame() -> None:
    assert read_frame_size(encode_vp8(draw_person(), max_bytes=10)) == (320, 240)
