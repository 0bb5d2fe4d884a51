"""Upper teeth: hidden behind the lip at small openings, seen in a smile, under a raised lip and in an open mouth."""

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.constraints.upper_teeth import UpperTeeth, find_upper_teeth
from conf.face.loading import load_face

TEETH = UpperTeeth(np.arange(3), overhang=0.38)
UPPER, LOWER, LEFT, RIGHT = (
    CONTROL_POINT_INDEX[f"inner_lip_{at}"] for at in ("upper_mid", "lower_mid", "corner_l", "corner_r")
)


def seen(*, raised: float = 0.0, opening: float = 0.0, wider: float = 0.0) -> float:
    """Return how far the teeth are below the upper lip, cm, negative while it covers them."""
    offsets = np.zeros((50, 3))
    offsets[UPPER, 1], offsets[LOWER, 1] = raised, raised - opening
    offsets[LEFT, 0], offsets[RIGHT, 0] = wider / 2, -wider / 2
    return TEETH.overhang + raised - TEETH.rise(offsets)


@pytest.mark.parametrize("opening", [0.0, 0.1, 0.3, 0.49])
@pytest.mark.parametrize("raised", [-0.1, 0.0, 0.1])
def test_speech_shows_no_teeth_at_openings_below_five_millimetres(opening: float, raised: float) -> None:
    assert seen(opening=opening, raised=raised) < 0


def test_a_smile_a_raised_lip_and_an_open_mouth_show_teeth() -> None:
    assert seen(wider=1.0, opening=0.2) > 0.1
    assert seen(raised=0.3, opening=0.3) > 0.1
    assert seen(opening=1.5) == pytest.approx(0.13)


def test_the_teeth_are_never_lower_than_peoples() -> None:
    assert seen(raised=0.5, wider=2.0, opening=2.0) == pytest.approx(0.13 + 0.5)


def test_teeth_that_do_not_hang_below_the_lip_are_left_alone() -> None:
    assert UpperTeeth(np.arange(3), overhang=-0.2).rise(np.zeros((50, 3))) == 0


def test_the_overhang_of_the_default_head_is_measured() -> None:
    face = load_face()
    assert face.rig is not None and face.rig.upper_teeth is not None
    assert face.rig.upper_teeth.overhang == pytest.approx(0.38, abs=0.02)
    assert find_upper_teeth(face.mesh.vertices, np.empty(0, np.int64), face.control_points) is None
