import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINT_LANDMARKS, CONTROL_POINTS
from conf.face.fapu import Fapu
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import LIP_GAP_CM
from conf.sender.tracking.canonical_face import CanonicalFace

OTHER_SIDE = {"l": "r", "r": "l"}


def test_left_mirrors_right_and_the_middle_is_in_the_middle() -> None:
    for point in CONTROL_POINTS:
        stem, _, side = point.name.rpartition("_")
        twin = f"{stem}_{OTHER_SIDE[side]}" if side in OTHER_SIDE else point.name
        assert np.allclose(MEAN_FACE[point.index] * [-1, 1, 1], MEAN_FACE[CONTROL_POINT_INDEX[twin]]), point.name


def test_it_is_a_face_with_shut_mouth_and_open_eyes_near_the_canonical_one(canonical: CanonicalFace) -> None:
    fapu = Fapu.measure(MEAN_FACE)
    assert 6 < fapu.es0 < 7
    assert 0.8 < fapu.irisd0 < 1.2
    lips = (
        MEAN_FACE[CONTROL_POINT_INDEX["inner_lip_upper_mid"], 1]
        - MEAN_FACE[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1]
    )
    assert lips == pytest.approx(LIP_GAP_CM, abs=0.01)
    known = CONTROL_POINT_LANDMARKS < 468
    away = np.linalg.norm(MEAN_FACE[known] - canonical.vertices[CONTROL_POINT_LANDMARKS[known]], axis=1)
    assert np.median(away) < 0.5
    assert away.max() < 1.1
