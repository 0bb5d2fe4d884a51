import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.symmetry import MIRROR_INDICES
from conf.sender.motion.expression_offsets import _load_map, expression_offsets
from conf.sender.tracking.blendshape_network import INDEX
from tools.train.expression import MIRRORED


def with_shapes(**strengths: float) -> NDArray[np.float64]:
    """Return the weights of a quiet face with some shapes stronger."""
    weights = _load_map()[1].copy()
    for name, strength in strengths.items():
        weights[INDEX[name]] += strength
    return weights


def test_a_quiet_face_is_not_moved() -> None:
    assert np.abs(expression_offsets(with_shapes())).max() < 1e-12


@pytest.mark.parametrize(
    ("shape", "point", "axis", "least"),
    [
        ("jawOpen", "chin_bottom", 1, -1.0),
        ("browInnerUp", "brow_inner_l", 1, 0.3),
        ("browOuterUpLeft", "brow_top_l", 1, 0.1),
        ("eyeBlinkRight", "eyelid_upper_r", 1, -0.15),
        ("mouthSmileLeft", "outer_lip_corner_l", 0, 0.1),
    ],
)
def test_shapes_move_what_they_are_named_after(shape: str, point: str, axis: int, least: float) -> None:
    moved = expression_offsets(with_shapes(**{shape: 1.0}))[CONTROL_POINT_INDEX[point], axis]
    assert moved / least > 1, moved


def test_the_other_side_moves_as_in_a_mirror() -> None:
    weights = np.random.default_rng(0).uniform(0, 1, 52)
    mirrored = expression_offsets(weights)[MIRROR_INDICES] * (-1, 1, 1)
    assert expression_offsets(weights[MIRRORED]) == pytest.approx(mirrored, abs=0.02)
