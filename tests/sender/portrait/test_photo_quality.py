from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.sender.portrait.photo_quality import (
    LOOK_EVERY_S,
    SAMPLES,
    TypicalPose,
    motion_penalty,
    sharpness,
    speed_penalty,
)
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import landmarks, motion

FRONTAL = HeadPose(np.zeros(3), np.zeros(2), -3.5)
TURNED = HeadPose(np.array([0, 0.4, 0]), np.zeros(2), -3.5)


STILL = np.zeros((CONTROL_POINT_COUNT, 3))


def marks(habit: TypicalPose, displacements: NDArray[np.float64] = STILL, pose: HeadPose = FRONTAL) -> float:
    return motion_penalty(motion(displacements, pose), habit).penalty


def test_until_more_is_known_a_neutral_face_that_looks_at_the_camera_is_best() -> None:
    shut, stirred = STILL.copy(), STILL + 120
    shut[CONTROL_POINT_INDEX["eyelid_upper_l"], 1] = -1000
    assert marks(TypicalPose()) == 0
    assert all(marks(TypicalPose(), d) > 0.9 for d in (shut, stirred))
    assert marks(TypicalPose(), pose=TURNED) > 0.9


def test_then_a_face_is_best_as_it_mostly_is() -> None:
    habit, talking, shout = TypicalPose(), STILL.copy(), STILL + 500
    talking[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] = -900
    for number in range(60):
        habit.sample(motion(shout if number % 10 == 9 else talking, TURNED), number / 10)
    assert marks(habit, talking, TURNED) < 1e-3
    assert marks(habit, shout, TURNED) > 3 and marks(habit, talking) > 0.9 and marks(habit, pose=TURNED) > 0.1


def test_a_habit_is_forgotten_when_another_takes_its_place() -> None:
    habit = TypicalPose()
    for number in range(2 * SAMPLES):
        habit.sample(motion(STILL + 200 if number < SAMPLES else STILL, FRONTAL), number * 1.01 * LOOK_EVERY_S)
    assert marks(habit) == 0


def test_a_face_that_moves_fast_is_worse_the_faster_it_moves() -> None:
    at_rest = replace(motion(pose=FRONTAL), timestamp=1.0)
    turning = replace(motion(pose=TURNED), timestamp=1.2)
    assert speed_penalty(at_rest, replace(at_rest, timestamp=1.1)) == 0
    assert speed_penalty(at_rest, turning) > speed_penalty(at_rest, replace(turning, timestamp=1.5)) > 0.5
    assert speed_penalty(at_rest, at_rest) == 0


def test_a_blurred_face_is_less_sharp() -> None:
    pixels = draw_person()
    blurred = np.asarray(cv2.GaussianBlur(pixels, (0, 0), 3), np.uint8)
    assert sharpness(blurred, landmarks()) < 0.5 * sharpness(pixels, landmarks())
