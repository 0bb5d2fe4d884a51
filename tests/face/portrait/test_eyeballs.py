import numpy as np

from conf.face.control_points import INDEX
from conf.face.portrait import contours
from conf.face.portrait.eyeballs import find_eyeballs
from conf.face.portrait.mesh import build_mesh
from tests.face.portrait.synthetic import face_shape

PLACES = build_mesh(face_shape()).places


def test_pupils_lie_between_the_lids() -> None:
    right, left = find_eyeballs(PLACES)
    assert INDEX["pupil_r"] in right.inside and INDEX["pupil_l"] in left.inside


def test_open_eyes_are_left_alone_and_shut_ones_press_what_is_inside_together() -> None:
    for eyeball in find_eyeballs(PLACES):
        same = PLACES.copy()
        eyeball.follow(same)
        np.testing.assert_allclose(same, PLACES)
        shut = PLACES.copy()
        shut[eyeball.upper[1:-1]] = shut[eyeball.lower[1:-1]] + (0, 1e-4)
        eyeball.follow(shut)
        heights = shut[eyeball.inside, 1]
        assert heights.max() <= shut[eyeball.upper, 1].max() + 1e-3
        assert heights.min() >= shut[eyeball.lower, 1].min() - 1e-3
    assert len(contours.UPPER_LID_L) == len(contours.LOWER_LID_L)


def test_the_whole_edge_shuts_as_far_as_its_middle() -> None:
    for eyeball in find_eyeballs(PLACES):
        half = PLACES.copy()
        middle = eyeball.upper[len(eyeball.upper) // 2]
        half[middle, 1] = half[eyeball.lower[len(eyeball.lower) // 2], 1] + 1e-3
        eyeball.follow(half)
        gaps = (half[eyeball.upper, 1] - half[eyeball.lower, 1])[1:-1]
        before = (PLACES[eyeball.upper, 1] - PLACES[eyeball.lower, 1])[1:-1]
        assert (gaps < 0.5 * before).all()
