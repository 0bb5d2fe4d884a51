import numpy as np

from conf.face.portrait import contours
from conf.face.portrait.lip_lid_gaps import MIN_GAP_CM, enforce_min_gap, inside_openings, widen_openings
from tests.support.synthetic_portrait import face_points

UPPER, LOWER = (contours.landmark_rows(line[1:-1]) for line in (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP))


def test_crossed_lips_get_the_minimum_gap_and_open_ones_are_unchanged() -> None:
    points = face_points()[:, :2]
    points[LOWER, 1] = points[UPPER, 1] + 0.1
    separated = enforce_min_gap(points, 1.0)
    assert (separated[UPPER, 1] - separated[LOWER, 1]).min() > 0.9 * MIN_GAP_CM
    wide = face_points()[:, :2]
    wide[LOWER, 1] -= 2.0
    np.testing.assert_allclose(enforce_min_gap(wide, 1.0)[UPPER + LOWER], wide[UPPER + LOWER])


def test_widening_separates_the_lips_and_moves_nothing_far_away() -> None:
    points = enforce_min_gap(face_points()[:, :2], 1.0)
    widened = widen_openings(points, points)
    assert (widened[UPPER, 1] - widened[LOWER, 1])[2:-2].min() > 0.5
    far = np.array([[-30.0, 40.0]])
    np.testing.assert_array_equal(widen_openings(far, points), far)


def test_positions_between_the_lips_are_inside() -> None:
    points = face_points()[:, :2]
    points[LOWER, 1] -= 2.0
    positions = np.array([[0.0, points[UPPER, 1].mean() - 1.0], [0.0, points[UPPER, 1].mean() + 1.0], [5.0, -5.0]])
    np.testing.assert_array_equal(inside_openings(positions, points, 0.1), [True, False, False])
