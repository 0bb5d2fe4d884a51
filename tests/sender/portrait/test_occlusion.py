import cv2
import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.occlusion import AppearanceMatcher
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import landmarks
from tests.support.synthetic_portrait import POSE, face_shape

STILL = np.zeros((CONTROL_POINT_COUNT, 3))


def shaded() -> np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]:
    """Return the person lit from the side: bare skin has no pattern to compare."""
    light = np.linspace(0.5, 1.1, 320)[None, :, None]
    return np.clip(draw_person() * light, 0, 255).astype(np.uint8)


def test_other_light_does_not_matter_and_a_hand_does() -> None:
    agreement = AppearanceMatcher(PortraitWarp(face_shape()), shaded())
    assert min(agreement.region_correlations(shaded(), STILL, POSE)) > 0.99
    darker = np.clip(shaded() * 0.7 + 20, 0, 255).astype(np.uint8)
    assert min(agreement.region_correlations(darker, STILL, POSE)) > 0.95
    hand = shaded()
    x, y = landmarks()[17, :2].astype(int).tolist()
    cv2.ellipse(hand, (x - 20, y), (26, 30), 0, 0, 360, (235, 235, 235), -1)
    mouth, eyes = agreement.region_correlations(hand, STILL, POSE)
    assert mouth < 0.7 < eyes
