import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.portrait import contours
from conf.sender.portrait.segmentation import MAX_CORNERS, PROBABLE_BACKGROUND, BodyPrior, segment_steps
from tests.support.drawn_person import SIZE, draw_person
from tests.support.portrait_subjects import landmarks


def person_before(background: NDArray[np.uint8] | tuple[int, int, int]) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the drawn person before a background, and his mask."""
    person = draw_person()
    mask = (person != person[0, 0]).any(axis=2)
    canvas = np.empty_like(person)
    canvas[:] = background
    canvas[mask] = person[mask]
    return canvas, mask


def segment_person(pixels: NDArray[np.uint8]) -> NDArray[np.float64]:
    *steps, outline = segment_steps(pixels, landmarks())
    assert outline is not None and not any(steps)
    return outline


def iou(outline: NDArray[np.float64], mask: NDArray[np.bool_]) -> float:
    """Return the intersection over union of the outline's inside and the mask."""
    inside = np.zeros(mask.shape, np.uint8)
    cv2.fillPoly(inside, [np.rint(outline * SIZE).astype(np.int32)], 1)
    return float(np.sum((inside > 0) & mask) / np.sum((inside > 0) | mask))


@pytest.mark.parametrize("wall", [(200, 120, 20), (60, 180, 60)], ids=["blue", "green"])
def test_a_person_before_a_plain_wall_is_segmented_by_colour(wall: tuple[int, int, int]) -> None:
    pixels, mask = person_before(wall)
    assert iou(segment_person(pixels), mask) > 0.85


def test_clothes_of_the_walls_hue_but_darker_belong_to_the_person() -> None:
    pixels, mask = person_before((190, 140, 90))
    clothes = (pixels == (60, 60, 60)).all(axis=2)
    pixels[clothes] = (75, 45, 25)  # navy
    assert clothes.sum() > 3000 and iou(segment_person(pixels), mask) > 0.85


def test_beside_the_neck_there_may_be_hair() -> None:
    oval = landmarks()[list(contours.OVAL), :2]
    mask = BodyPrior.from_oval(oval).draw(SIZE[::-1], PROBABLE_BACKGROUND)
    x, y = landmarks()[152, :2].astype(int)
    width = int(np.ptp(oval[:, 0]))
    assert mask[y, x - round(0.8 * width)] and mask[y - width // 3, x + round(0.75 * width)]


@pytest.mark.slow
def test_a_person_in_a_room_is_segmented_from_the_landmarks() -> None:
    rng = np.random.default_rng(2)
    room = cv2.resize(rng.integers(90, 250, (12, 16, 3), dtype=np.uint8), SIZE, interpolation=cv2.INTER_CUBIC)
    room[..., 0] = 250 - room[..., 2]
    pixels, mask = person_before(np.asarray(room, np.uint8))
    outline = segment_person(pixels)
    assert iou(outline, mask) > 0.7
    assert 3 <= len(outline) <= MAX_CORNERS and outline.min() >= 0 and outline.max() <= 1


@pytest.mark.slow
def test_the_same_image_gives_the_same_outline() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (240, 320, 3), dtype=np.uint8)
    pixels, _ = person_before(noise)
    np.testing.assert_array_equal(segment_person(pixels), segment_person(pixels))
