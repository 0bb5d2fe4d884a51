import cv2
import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX
from conf.face.head_pose import HeadPose
from conf.sender.portrait.choice import judge, sharpness
from tests.receiver.portrait.people import draw_person
from tests.sender.portrait.subjects import landmarks, motion

FRONTAL = HeadPose(np.zeros(3), np.zeros(2), -3.5)


def test_a_neutral_face_that_looks_at_the_camera_is_best() -> None:
    still = np.zeros((CONTROL_POINT_COUNT, 3))
    shut, gaping, stirred = still.copy(), still.copy(), still + 300
    shut[INDEX["eyelid_upper_l"], 1] = -1000
    gaping[INDEX["inner_lip_lower_mid"], 1] = -900
    best = judge(motion(still, FRONTAL)).marks
    turned = judge(motion(still, HeadPose(np.array([0, 0.5, 0]), np.zeros(2), -3.5))).marks
    assert best == 0
    assert all(judge(motion(d, FRONTAL)).marks > 0.9 for d in (shut, gaping, stirred)) and turned > 0.9


def test_a_blurred_face_is_less_sharp() -> None:
    pixels = draw_person()
    blurred = np.asarray(cv2.GaussianBlur(pixels, (0, 0), 3), np.uint8)
    assert sharpness(blurred, landmarks()) < 0.5 * sharpness(pixels, landmarks())
