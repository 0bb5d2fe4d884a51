import cv2
import numpy as np
import pytest

from conf.face.control_points import LANDMARKS
from conf.face.portrait.features import MOUTH
from conf.protocol.portrait import decode_thing, encode_thing
from conf.sender.portrait.patchwork import PatchBudget, Patchwork, cut_patch, make_patch, match_light, similarity
from tests.receiver.portrait.people import draw_person
from tests.sender.portrait.subjects import landmarks


def keys(*values: int) -> np.ndarray[tuple[int], np.dtype[np.int8]]:
    return np.array(values, np.int8)


def test_novelty_is_distance_from_all_that_is_kept() -> None:
    work = Patchwork(MOUTH, PatchBudget(200, 4, 10.0), keys(0, 0))
    assert work.novelty(keys(3, 4)) == pytest.approx(0.5)
    assert work.novelty(keys(30, 0)) == pytest.approx(3)
    work.take(keys(30, 0))
    assert work.novelty(keys(30, 0)) == 0


def test_the_patch_missed_least_makes_room() -> None:
    work = Patchwork(MOUTH, PatchBudget(200, 3, 10.0), keys(0, 0))
    slots = [work.take(keys(*key)) for key in ((50, 0), (0, 50), (4, 50))]
    assert slots == [0, 1, 2]
    assert work.take(keys(-50, 0)) in (1, 2)


def test_more_slots_than_travel_are_refused() -> None:
    with pytest.raises(ValueError, match="slots must be 1 to"):
        PatchBudget(200, 99, 1.0)


def test_a_cut_out_has_its_points_where_they_are_seen() -> None:
    pixels = draw_person()
    crop, points = cut_patch(pixels, landmarks(), MOUTH, centimetre=7.2)
    assert crop.shape[1] > crop.shape[0]
    upper = points[MOUTH.points.index(1)] * crop.shape[1::-1]
    x, y = landmarks()[13, :2].astype(int)
    np.testing.assert_array_equal(crop[int(upper[1]), int(upper[0])], pixels[y, x])


def test_a_face_at_the_picture_s_edge_is_cut_all_the_same() -> None:
    aside = landmarks() + np.array([150, 110, 0], np.float32)
    crop, _ = cut_patch(draw_person(), aside, MOUTH, centimetre=7.2)
    assert min(crop.shape[:2]) >= 8


def test_light_is_matched_along_the_border() -> None:
    photo = draw_person()
    crop, points = cut_patch(photo, landmarks(), MOUTH, centimetre=7.2)
    dark = np.clip(crop * 0.7, 0, 255).astype(np.uint8)
    photo_points = landmarks()[LANDMARKS[list(MOUTH.points)], :2] / (320, 240)
    matched = match_light(dark, points, photo, photo_points)
    assert np.abs(matched.astype(float) - crop).mean() < 4 < np.abs(dark.astype(float) - crop).mean()


def test_similarity_is_found_again() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 50, (12, 2))
    matrix = cv2.getRotationMatrix2D((3, 4), 30, 1.3)
    np.testing.assert_allclose(similarity(points, points @ matrix[:, :2].T + matrix[:, 2]), matrix, atol=1e-9)


def test_a_patch_is_small_and_travels() -> None:
    crop, points = cut_patch(draw_person(), landmarks(), MOUTH, centimetre=7.2)
    data = encode_thing(make_patch(crop, points, keys(1, 2, 3), where=(1, 0, 2), budget=250))
    assert len(data) < 330
    assert decode_thing(data)
