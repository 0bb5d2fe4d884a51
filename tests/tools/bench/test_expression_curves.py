"""The curves of expressions measure what their names say, in eye distances."""

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.expression_curves import GRADIENTS, NAMES, REPORTED, reported_curves

EYES = float(
    np.linalg.norm(
        MEAN_FACE[CONTROL_POINT_INDEX["eye_outer_corner_l"]] - MEAN_FACE[CONTROL_POINT_INDEX["eye_outer_corner_r"]]
    )
)
UP, LEFT = (0.0, EYES / 10, 0.0), (EYES / 10, 0.0, 0.0)


@pytest.mark.parametrize(
    ("moved", "offset", "changes"),
    [
        ("brow_inner_l brow_inner_r", UP, {"inner brow": 0.1, "slant": 0.1}),
        ("brow_inner_l", UP, {"inner brow": 0.05, "slant": 0.05}),
        ("brow_inner_l", LEFT, {"knit": 0.1}),
        ("inner_lip_upper_mid", UP, {"mouth opening": 0.1, "upper lip thickness": -0.1}),
        ("outer_lip_upper_mid", UP, {"upper lip thickness": 0.1, "upper-lip raise": 0.1}),
        ("eyelid_upper_l eyelid_upper_r", UP, {"lids": 0.1}),
        ("pupil_l pupil_r", LEFT, {"gaze x": 0.1}),
        ("chin_bottom", UP, {}),
    ],
)
def test_a_motion_changes_its_own_curves(moved: str, offset: tuple[float, ...], changes: dict[str, float]) -> None:
    points = MEAN_FACE.copy()
    points[[CONTROL_POINT_INDEX[name] for name in moved.split()]] += offset
    before, after = reported_curves(np.stack([MEAN_FACE, points]))
    assert dict(zip(REPORTED, after - before, strict=True)) == pytest.approx(dict.fromkeys(REPORTED, 0.0) | changes)


def test_a_moved_or_deeper_face_keeps_its_expression() -> None:
    """Brows, corners of the mouth and pupils are measured from an origin, the rest from another point."""
    from_origin = ("brow_inner", "brow_outer", "lip_corner", "gaze")
    for name, gradient in zip(NAMES, GRADIENTS, strict=True):
        expected = 1.0 if name.startswith(from_origin) else 0.0
        assert np.abs(gradient.sum(axis=0)).sum() == pytest.approx(expected)
        assert not gradient[:, 2].any()
