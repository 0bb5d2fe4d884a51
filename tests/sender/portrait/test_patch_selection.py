import numpy as np
import pytest

from conf.face.portrait.patch_features import MOUTH
from conf.protocol.portrait.patch import POINT_STEPS, STEP_COUNT, encode_patch
from conf.protocol.portrait.probability_model import load_portrait_model
from conf.sender.portrait.patch_selection import PatchBudget, PatchSet, extract_patch, make_patch, match_colour
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import landmarks

MODEL = load_portrait_model().regions[0]


def keys(*values: int) -> np.ndarray[tuple[int], np.dtype[np.int8]]:
    return np.array(values, np.int8)


def test_novelty_is_distance_from_all_that_is_kept() -> None:
    work = PatchSet(MOUTH, PatchBudget(200, 4, 10.0), keys(0, 0))
    assert work.novelty(keys(3, 4)) == pytest.approx(0.5)
    assert work.novelty(keys(30, 0)) == pytest.approx(3)
    work.assign_slot(keys(30, 0))
    assert work.novelty(keys(30, 0)) == 0


def test_the_patch_missed_least_makes_room() -> None:
    work = PatchSet(MOUTH, PatchBudget(200, 3, 10.0), keys(0, 0))
    slots = [work.assign_slot(keys(*key)) for key in ((50, 0), (0, 50), (4, 50))]
    assert slots == [0, 1, 2]
    assert work.assign_slot(keys(-50, 0)) in (1, 2)


def test_more_slots_than_travel_are_refused() -> None:
    with pytest.raises(ValueError, match="slots must be 1 to"):
        PatchBudget(200, 99, 1.0)


def test_a_cut_out_has_its_points_where_they_are_seen() -> None:
    pixels = draw_person()
    cut = extract_patch(pixels, landmarks(), MOUTH, centimetre=7.2)
    assert cut.pixels.shape[1] > cut.pixels.shape[0]
    upper = cut.points[MOUTH.points.index(1)] * cut.pixels.shape[1::-1]
    x, y = landmarks()[13, :2].astype(int)
    np.testing.assert_array_equal(cut.pixels[int(upper[1]), int(upper[0])], pixels[y, x])
    assert cut.seen[int(upper[1]), int(upper[0])] == 1 and cut.seen[0, 0] == 0


def test_a_face_at_the_picture_s_edge_is_cut_all_the_same() -> None:
    aside = landmarks() + np.array([150, 110, 0], np.float32)
    cut = extract_patch(draw_person(), aside, MOUTH, centimetre=7.2)
    assert min(cut.pixels.shape[:2]) >= 8 and cut.seen.shape == cut.pixels.shape[:2]


def test_light_is_matched_along_the_border() -> None:
    crop = extract_patch(draw_person(), landmarks(), MOUTH, centimetre=7.2).pixels
    dark = np.clip(crop * 0.7, 0, 255).astype(np.uint8)
    matched = match_colour(dark, crop.astype(np.float64))
    assert np.abs(matched - crop).mean() < 4 < np.abs(dark.astype(float) - crop).mean()


def test_a_patch_is_as_fine_as_its_budget_allows() -> None:
    noise = np.random.default_rng(0).normal(0, 25, (40, 60, 3))
    points, key = MODEL.points.mean / POINT_STEPS, np.zeros(len(MODEL.descriptor_scale), np.int8)
    sizes, steps = [], []
    for budget in (150, 400, 1200):
        patch = make_patch(noise, points, key, target=(1, 0, 2), budget=budget)
        sizes.append(len(encode_patch(patch)) / budget)
        steps.append(patch.step)
    assert all(0.6 < size <= 1 for size in sizes) and steps == sorted(steps, reverse=True)


def test_a_budget_for_nothing_gives_the_coarsest_patch() -> None:
    points, key = MODEL.points.mean / POINT_STEPS, np.zeros(len(MODEL.descriptor_scale), np.int8)
    assert make_patch(np.zeros((8, 8, 3)), points, key, target=(0, 0, 0), budget=1).step == STEP_COUNT - 1
