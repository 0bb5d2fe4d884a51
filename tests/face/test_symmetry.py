import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.ppc import read_ppc
from conf.face.symmetry import MIRROR_INDICES, SIDE_WEIGHTS, mirror_motion, side_weighted


def random_displacements() -> np.ndarray:
    return np.random.default_rng(1).normal(size=(CONTROL_POINT_COUNT, 3)).astype(np.float32)


def test_mirroring_twice_gives_the_motion() -> None:
    displacements = random_displacements()
    np.testing.assert_array_equal(mirror_motion(mirror_motion(displacements)), displacements)
    assert not np.array_equal(mirror_motion(displacements), displacements)


def test_mirrored_points_lie_on_opposite_sides_of_the_default_head() -> None:
    points = read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    mirror = points[MIRROR_INDICES] * [-1, 1, 1]
    assert np.linalg.norm(mirror - points, axis=1).max() < 0.3  # centimetres: nearly symmetric
    assert MIRROR_INDICES[CONTROL_POINT_INDEX["brow_inner_l"]] == CONTROL_POINT_INDEX["brow_inner_r"]
    assert MIRROR_INDICES[CONTROL_POINT_INDEX["chin_boss"]] == CONTROL_POINT_INDEX["chin_boss"]


def test_both_sides_add_up_to_the_motion() -> None:
    displacements = random_displacements()
    np.testing.assert_allclose(side_weighted(displacements, "l") + side_weighted(displacements, "r"), displacements)
    assert SIDE_WEIGHTS["l"][CONTROL_POINT_INDEX["pupil_l"]] == 1.0
    assert SIDE_WEIGHTS["l"][CONTROL_POINT_INDEX["pupil_r"]] == 0.0
    assert SIDE_WEIGHTS["r"][CONTROL_POINT_INDEX["chin_bottom"]] == 0.5
