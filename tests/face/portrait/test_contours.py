import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_LANDMARKS
from conf.face.portrait import contours


def test_control_points_are_first_and_no_landmark_is_repeated() -> None:
    np.testing.assert_array_equal(contours.PORTRAIT_LANDMARKS[:CONTROL_POINT_COUNT], CONTROL_POINT_LANDMARKS)
    assert len(set(contours.PORTRAIT_LANDMARKS.tolist())) == len(contours.PORTRAIT_LANDMARKS)


def test_rows_refer_to_the_landmarks() -> None:
    np.testing.assert_array_equal(contours.PORTRAIT_LANDMARKS[contours.landmark_rows(contours.OVAL)], contours.OVAL)


def test_facing_outlines_have_only_their_corners_in_common() -> None:
    for upper, lower in (
        (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP),
        (contours.UPPER_LID_R, contours.LOWER_LID_R),
        (contours.UPPER_LID_L, contours.LOWER_LID_L),
    ):
        assert (upper[0], upper[-1]) == (lower[0], lower[-1])
        assert len(set(upper) & set(lower)) == 2
