from dataclasses import replace

import cv2
import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.face.portrait.photo_mesh import border_extension
from conf.face.portrait.photographed_face import PhotographedFace
from conf.receiver.portrait.border_extension import extend_border
from tests.support.synthetic_portrait import POSE, face_shape

SIZE = (320, 240)
HAIR, SKIN, CLOTHES = (30, 40, 60), (130, 160, 210), (120, 60, 40)


def face_at(position: tuple[float, float], scale: float = 0.04) -> PhotographedFace:
    return face_shape(HeadPose(POSE.rotation, np.array(position), float(np.log(scale))))


# A head so large and high that the upper border cuts off its crown.
HIGH = face_at((0.05, 0.13))


def draw(face: PhotographedFace) -> tuple[np.ndarray, np.ndarray]:
    """Return colours and alpha of a head with hair, on a body that reaches the lower border."""
    colours, alpha = np.zeros((SIZE[1], SIZE[0], 3), np.uint8), np.zeros(SIZE[::-1], np.uint8)
    x, y = np.rint(face.pose.position * (240, -240) + (160, 120)).astype(int).tolist()
    scale = 240 * float(np.exp(face.pose.log_scale))
    for image, body, hair, skin in ((colours, CLOTHES, HAIR, SKIN), (alpha, 255, 255, 255)):
        cv2.rectangle(image, (round(x - 9 * scale), round(y + 11 * scale)), (round(x + 9 * scale), 240), body, -1)
        cv2.ellipse(image, (x, round(y - 2 * scale)), (round(8.5 * scale), round(12 * scale)), 0, 0, 360, hair, -1)
        cv2.ellipse(image, (x, y), (round(7 * scale), round(9 * scale)), 0, 0, 360, skin, -1)
    return colours, alpha


def test_the_margin_surrounds_the_unchanged_photo() -> None:
    colours, alpha = draw(HIGH)
    extended, extended_alpha, margin = extend_border(colours, alpha, HIGH)
    x, y = np.rint(margin * SIZE).astype(int)
    assert x == y == np.ceil(border_extension(HIGH) * 240)
    np.testing.assert_array_equal(extended[y:-y, x:-x], colours)
    np.testing.assert_array_equal(extended_alpha[y:-y, x:-x], alpha)


def test_a_head_cut_off_has_a_round_opaque_crown_of_hair() -> None:
    colours, alpha = draw(HIGH)
    extended, extended_alpha, margin = extend_border(colours, alpha, HIGH)
    m = round(float(margin[1]) * 240)
    centre = m + round(160 + 240 * HIGH.pose.position[0])
    heights = np.count_nonzero(extended_alpha[:m] > 127, axis=0)
    assert extended_alpha[m - 5, centre] == 255
    assert 5 < heights[centre] < 0.8 * m, "it ends within the margin"
    assert heights[centre] > heights[centre - 25] >= heights[centre - 45], "and is round"
    assert extended_alpha[:m, : m + 40].max() == 0 and extended_alpha[:m, -m:].max() == 0
    crown = extended[m - heights[centre] // 2, centre].astype(int)
    assert np.abs(crown - HAIR).max() < 40


def test_a_forehead_cut_off_has_hair_above_it() -> None:
    face = face_at((0.0, 0.42))
    colours, alpha = draw(face)
    extended, extended_alpha, margin = extend_border(colours, alpha, face)
    m = round(float(margin[1]) * 240)
    assert np.abs(colours[0, 160].astype(int) - SKIN).max() < 30
    top = m - np.count_nonzero(extended_alpha[:m, m + 160] > 127) + 3
    assert np.abs(extended[top, m + 160].astype(int) - HAIR).max() < 45


def test_the_body_continues_below_the_border() -> None:
    colours, alpha = draw(HIGH)
    extended, extended_alpha, margin = extend_border(colours, alpha, HIGH)
    m = round(float(margin[1]) * 240)
    below = extended_alpha[-m:, m : m + 320]
    np.testing.assert_array_equal(below[10], alpha[-1])
    assert np.abs(extended[-m + 5, m + 172].astype(int) - CLOTHES).max() < 10


def test_a_neckline_shows_the_neck_only_once() -> None:
    colours, alpha = draw(HIGH)
    colours[225:, 160:184] = SKIN  # an open collar that the border cuts off
    extended, _, margin = extend_border(colours, alpha, HIGH)
    m = round(float(margin[1]) * 240)
    below = extended[-m + 2 : -m + 14, m + 165 : m + 180].astype(int)
    assert np.abs(below - CLOTHES).max() < 30


@pytest.mark.parametrize("value", [0, 255])
def test_an_image_without_person_or_without_background_is_extended_too(value: int) -> None:
    colours, alpha = draw(HIGH)
    extended, extended_alpha, _ = extend_border(colours, np.full_like(alpha, value), HIGH)
    assert extended.shape[:2] == extended_alpha.shape


def test_a_head_outside_the_photo_is_extended() -> None:
    colours, alpha = draw(HIGH)
    for position in ((0.0, 1.5), (-1.5, 0.0), (0.0, -1.5)):
        extend_border(colours, alpha, replace(HIGH, pose=HeadPose(POSE.rotation, np.array(position), POSE.log_scale)))
