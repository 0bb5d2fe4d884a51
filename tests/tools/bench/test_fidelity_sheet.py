"""The sheet shows the moments with the greatest errors."""

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.expression_curves import REPORTED
from tools.bench.fidelity_sheet import expression_errors, worst_moments


def test_the_worst_moments_are_apart_and_in_order() -> None:
    errors = np.array([0.1, 0.9, 0.8, 0.2, 0.7, 0.3])
    times = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25])
    assert worst_moments(errors, times, 2, spacing=0.4) == [1, 4]
    assert worst_moments(errors, times, 9, spacing=0.4) == [1, 4]
    assert worst_moments(errors, times, 3, spacing=0.0) == [1, 2, 4]


def test_only_what_is_drawn_differently_is_an_error() -> None:
    source = np.tile(MEAN_FACE, (5, 1, 1))
    lips = [CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")]
    source[2, lips, 1] -= 1.0
    drawn = 1.1 * source
    assert expression_errors(source, drawn) == pytest.approx(0.0, abs=1e-9)
    drawn[2, lips, 1] += 0.5
    errors = expression_errors(source, drawn)
    assert errors[2].argmax() == list(REPORTED).index("mouth opening")
    assert np.delete(errors, 2, axis=0) == pytest.approx(0.0, abs=1e-9)
