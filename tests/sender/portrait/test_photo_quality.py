from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.sender.portrait.photo_quality import (
    SAMPLE_INTERVAL_S,
    SAMPLES,
    TypicalPose,
    motion_penalty,
    sharpness,
    speed_penalty,
)
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import landmarks, motion, still

FRONTAL = HeadPose(np.zeros(3), np.zeros(2), -3.5)
TURNED = HeadPose(np.array([0, 0.4, 0]), np.zeros(2), -3.5)


def penalty(typical: TypicalPose, displacements: NDArray[np.float64] | None = None, pose: HeadPose = FRONTAL) -> float:
    return motion_penalty(motion(displacements, pose), typical)


def test_at_the_start_a_neutral_face_towards_the_camera_has_no_penalty() -> None:
    shut = still()
    shut[CONTROL_POINT_INDEX["eyelid_upper_l"], 1] = -1000
    assert penalty(TypicalPose()) == 0
    assert all(penalty(TypicalPose(), displacements) > 0.9 for displacements in (shut, still() + 120))
    assert penalty(TypicalPose(), pose=TURNED) > 0.9


def test_later_the_most_frequent_expression_has_no_penalty() -> None:
    typical, talking, shout = TypicalPose(), still(), still() + 500
    talking[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] = -900
    for i in range(60):
        typical.sample(motion(shout if i % 10 == 9 else talking, TURNED), i / 10)
    assert penalty(typical, talking, TURNED) < 1e-3
    assert penalty(typical, shout, TURNED) > 3 and penalty(typical, talking) > 0.9
    assert penalty(typical, pose=TURNED) > 0.1


def test_an_old_typical_expression_is_forgotten() -> None:
    typical = TypicalPose()
    for i in range(2 * SAMPLES):
        typical.sample(motion(still() + 200 * (i < SAMPLES), FRONTAL), i * 1.01 * SAMPLE_INTERVAL_S)
    assert penalty(typical) == 0


def test_the_penalty_rises_with_the_speed() -> None:
    at_rest = replace(motion(pose=FRONTAL), timestamp=1.0)
    turning = replace(motion(pose=TURNED), timestamp=1.2)
    assert speed_penalty(at_rest, replace(at_rest, timestamp=1.1)) == 0
    assert speed_penalty(at_rest, turning) > speed_penalty(at_rest, replace(turning, timestamp=1.5)) > 0.5
    assert speed_penalty(at_rest, at_rest) == 0


def test_a_blurred_face_is_less_sharp() -> None:
    pixels = draw_person()
    blurred = np.asarray(cv2.GaussianBlur(pixels, (0, 0), 3), np.uint8)
    assert sharpness(blurred, landmarks()) < 0.5 * sharpness(pixels, landmarks())
