"""The pupil that is drawn: it follows the corners of its eye and stays where it can be seen."""

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import default_points
from conf.face.deformation.constraints.gaze_limits import MAX_SIDEWAYS_CM, limit_gaze

POINTS = default_points()
LEFT = PUPILS[0]
LIDS = [CONTROL_POINT_INDEX[f"eyelid_{lid}_l"] for lid in ("upper", "lower")]
SLIT = float(np.subtract(*POINTS[LIDS, 1]))


def looking(x: float, y: float, *, closed: float = 0.0) -> np.ndarray:
    """Return offsets of a left pupil, and of an upper lid that has closed this part of the slit."""
    offsets = np.zeros((50, 3))
    offsets[LEFT] = x, y, 0.5
    offsets[LIDS[0], 1] = -closed * SLIT
    return offsets


def test_the_pupil_follows_the_corners_of_its_eye() -> None:
    drawn = limit_gaze(LEFT, POINTS, looking(0.1, -0.05), np.array([0.02, 0.03, 0.4]))
    assert drawn == pytest.approx([0.12, -0.02, 0.0])


@pytest.mark.parametrize("x", [-2.0, 2.0])
def test_a_pupil_stays_beside_the_corner_of_its_eye(x: float) -> None:
    assert limit_gaze(LEFT, POINTS, looking(x, 0.0), np.zeros(3))[0] == pytest.approx(np.sign(x) * MAX_SIDEWAYS_CM)


@pytest.mark.parametrize("y", [-1.0, -0.3, 0.0, 0.3, 1.0])
@pytest.mark.parametrize("closed", [0.0, 0.2, 0.4])
def test_half_of_the_iris_is_seen_while_lids_are_open(y: float, closed: float) -> None:
    offsets = looking(0.0, y, closed=closed)
    height = POINTS[LEFT, 1] + limit_gaze(LEFT, POINTS, offsets, np.zeros(3))[1]
    upper, lower = POINTS[LIDS, 1] + offsets[LIDS, 1]
    assert lower < height < upper


def test_a_closed_lid_does_not_push_the_eye_down() -> None:
    assert limit_gaze(LEFT, POINTS, looking(0.1, 0.05, closed=1.0), np.zeros(3)) == pytest.approx([0.1, 0.05, 0.0])
