import numpy as np
import pytest

from conf.face.portrait.patch_features import MOUTH
from conf.protocol.portrait.patch import POINT_STEPS, STEP_COUNT, encode_patch
from conf.protocol.portrait.probability_model import load_portrait_model
from conf.sender.portrait.patch_extraction import extract_patch, make_patch, match_colour
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import landmarks

MODEL = load_portrait_model().regions[0]
POINTS, DESCRIPTOR = MODEL.points.mean / POINT_STEPS, np.zeros(len(MODEL.descriptor_scale), np.int8)


def test_the_control_points_of_a_crop_are_where_the_frame_shows_them() -> None:
    pixels = draw_person()
    crop, points, weight = extract_patch(pixels, landmarks(), MOUTH, px_per_cm=7.2)
    assert crop.shape[1] > crop.shape[0]
    upper = points[MOUTH.points.index(1)] * crop.shape[1::-1]
    x, y = landmarks()[13, :2].astype(int)
    np.testing.assert_array_equal(crop[int(upper[1]), int(upper[0])], pixels[y, x])
    assert weight[int(upper[1]), int(upper[0])] == 1 and weight[0, 0] == 0


def test_a_face_at_the_border_of_the_image_gives_a_crop() -> None:
    aside = landmarks() + np.array([150, 110, 0], np.float32)
    crop, _, weight = extract_patch(draw_person(), aside, MOUTH, px_per_cm=7.2)
    assert min(crop.shape[:2]) >= 8 and weight.shape == crop.shape[:2]


def test_colours_are_matched_along_the_border() -> None:
    crop = extract_patch(draw_person(), landmarks(), MOUTH, px_per_cm=7.2)[0]
    dark = np.clip(crop * 0.7, 0, 255).astype(np.uint8)
    matched = match_colour(dark, crop.astype(np.float64))
    assert np.abs(matched - crop).mean() < 4 < np.abs(dark.astype(float) - crop).mean()


@pytest.mark.slow
def test_a_patch_is_as_fine_as_its_bytes_allow() -> None:
    noise = np.random.default_rng(0).normal(0, 25, (40, 60, 3))
    sizes, steps = [], []
    for max_bytes in (150, 400, 1200):
        patch = make_patch(noise, POINTS, DESCRIPTOR, target=(1, 0, 2), max_bytes=max_bytes)
        sizes.append(len(encode_patch(patch)) / max_bytes)
        steps.append(patch.step)
    assert all(0.6 < size <= 1 for size in sizes) and steps == sorted(steps, reverse=True)


def test_too_few_bytes_give_the_coarsest_patch() -> None:
    patch = make_patch(np.zeros((8, 8, 3)), POINTS, DESCRIPTOR, target=(0, 0, 0), max_bytes=1)
    assert patch.step == STEP_COUNT - 1
