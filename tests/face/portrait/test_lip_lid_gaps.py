import numpy as np

from conf.face.portrait import contours
from conf.face.portrait.lip_lid_gaps import LEAST_GAP_CM, enforce_min_gap, inside_openings, widen_openings
from tests.support.synthetic_portrait import face_points

UPPER, LOWER = (contours.landmark_rows(line[1:-1]) for line in (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP))


def test_crossed_lips_are_parted_and_open_ones_left_alone() -> None:
    points = face_points()[:, :2]
    points[LOWER, 1] = points[UPPER, 1] + 0.1
    parted = enforce_min_gap(points, 1.0)
    assert (parted[UPPER, 1] - parted[LOWER, 1]).min() > 0.9 * LEAST_GAP_CM
    wide = face_points()[:, :2]
    wide[LOWER, 1] -= 2.0
    np.testing.assert_allclose(enforce_min_gap(wide, 1.0)[UPPER + LOWER], wide[UPPER + LOWER])


def test_opening_moves_lips_apart_and_nothing_far_away() -> None:
    points = enforce_min_gap(face_points()[:, :2], 1.0)
    opened = widen_openings(points, points, 1.0)
    assert (opened[UPPER, 1] - opened[LOWER, 1])[2:-2].min() > 0.5
    far = np.array([[-30.0, 40.0]])
    np.testing.assert_array_equal(widen_openings(far, points, 1.0), far)


def test_between_lines() -> None:
    points = face_points()[:, :2]
    points[LOWER, 1] -= 2.0
    places = np.array([[0.0, points[UPPER, 1].mean() - 1.0], [0.0, points[UPPER, 1].mean() + 1.0], [5.0, -5.0]])
    np.testing.assert_array_equal(inside_openings(places, points, 0.1), [True, False, False])
