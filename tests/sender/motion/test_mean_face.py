import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINT_LANDMARKS, CONTROL_POINTS
from conf.face.fapu import Fapu
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import LIP_GAP_CM
from conf.sender.tracking.canonical_face import CanonicalFace

OTHER_SIDE = {"l": "r", "r": "l"}


def points_named(*names: str) -> list[int]:
    return [CONTROL_POINT_INDEX[name] for name in names]


def test_every_point_has_a_position_and_left_mirrors_right() -> None:
    for point in CONTROL_POINTS:
        stem, _, side = point.name.rpartition("_")
        twin = f"{stem}_{OTHER_SIDE[side]}" if side in OTHER_SIDE else point.name
        assert np.allclose(MEAN_FACE[point.index] * [-1, 1, 1], MEAN_FACE[CONTROL_POINT_INDEX[twin]]), point.name
        assert MEAN_FACE[point.index, 2] > 2, point.name
        assert np.sign(MEAN_FACE[point.index, 0]) == {"l": 1, "r": -1}.get(side, 0), point.name
    assert MEAN_FACE[CONTROL_POINT_INDEX["pupil_l"]] == pytest.approx([3.32, 2.92, 3.56])


def test_the_mean_face_has_a_shut_mouth_and_open_eyes_and_is_near_the_canonical_one(canonical: CanonicalFace) -> None:
    fapu = Fapu.measure(MEAN_FACE)
    assert 6 < fapu.es0 < 7
    assert 0.8 < fapu.irisd0 < 1.2
    upper, lower = points_named("inner_lip_upper_mid", "inner_lip_lower_mid")
    assert MEAN_FACE[upper, 1] - MEAN_FACE[lower, 1] == pytest.approx(LIP_GAP_CM, abs=0.01)
    known = CONTROL_POINT_LANDMARKS < 468
    distances = np.linalg.norm(MEAN_FACE[known] - canonical.vertices[CONTROL_POINT_LANDMARKS[known]], axis=1)
    assert np.median(distances) < 0.5
    assert distances.max() < 1.1
