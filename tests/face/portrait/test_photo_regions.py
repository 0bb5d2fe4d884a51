import numpy as np

from conf.face.control_points import LOWER_LID, LOWER_LIP, UPPER_LIP
from conf.face.portrait import contours
from conf.face.portrait.photo_regions import split_photo_regions
from tests.support.synthetic_portrait import face_points


def test_weights_sum_to_1_and_each_lip_follows_its_own_points() -> None:
    regions = split_photo_regions(face_points()[:, :2])
    weights = np.array([field.weights for field in regions.fields])
    np.testing.assert_allclose(weights.sum(axis=0), 1)
    upper = contours.landmark_rows(contours.UPPER_INNER_LIP[1:-1])
    has_lower = [not set(LOWER_LIP) <= set(field.excluded) for field in regions.fields]
    assert weights[np.ix_(has_lower, upper)].max() == 0
    lower = contours.landmark_rows(contours.LOWER_INNER_LIP[1:-1])
    has_upper = [not set(UPPER_LIP) <= set(field.excluded) for field in regions.fields]
    assert weights[np.ix_(has_upper, lower)].max() == 0
    assert any(set(LOWER_LID) <= set(field.excluded) for field in regions.fields)
