"""Teeth are found between the lips of an image, and below the upper lip of a head."""

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import LOWER_LIP, UPPER_LIP, control_point_indices
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.loading import load_face
from tools.bench.teeth import INNER_LIPS, teeth_between_lips, visible_teeth

SKIN, DARK, TOOTH, RED = (120, 150, 200), (20, 20, 40), (190, 200, 205), (60, 60, 150)  # BGR


def mouth(colour: tuple[int, int, int]) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return an image with an open mouth of a colour in red lips, and its landmarks."""
    image = np.full((200, 200, 3), SKIN, np.uint8)
    image[120:170, 60:140] = RED
    image[130:160, 70:130] = colour
    landmarks = np.full((478, 3), 50.0)
    angles = np.pi - np.arange(20) * np.pi / 10
    landmarks[list(INNER_LIPS), :2] = np.stack([100 + 28 * np.cos(angles), 145 - 14 * np.sin(angles)], axis=1)
    return image, landmarks


@pytest.mark.parametrize(("colour", "share"), [(TOOTH, 1.0), (DARK, 0.0), (RED, 0.0)])
def test_teeth_are_bright_and_pale(colour: tuple[int, int, int], share: float) -> None:
    assert teeth_between_lips(*mouth(colour)) == pytest.approx(share, abs=0.05)


def test_only_the_upper_half_counts() -> None:
    image, landmarks = mouth(DARK)
    image[147:160, 70:130] = TOOTH
    assert teeth_between_lips(image, landmarks) < 0.1


@pytest.fixture(scope="module")
def head() -> FaceModel:
    """Return the default head."""
    return load_face()


@pytest.mark.parametrize(("raised", "lowered", "shown"), [(0.0, 0.0, 0.0), (0.0, 0.4, 0.0), (0.4, 0.4, 0.35)])
def test_a_raised_lip_shows_the_teeth_of_a_head(head: FaceModel, raised: float, lowered: float, shown: float) -> None:
    displacements = np.zeros((50, 3))
    displacements[UPPER_LIP, 1], displacements[LOWER_LIP, 1] = raised, -lowered
    displacements[control_point_indices("chin"), 1] = -0.7 * lowered
    units = displacements / head.fapu.lengths()
    assert visible_teeth(head, LipOpening(head), units, head.fapu) == pytest.approx(shown, abs=0.1)
