import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.patch_features import MOUTH
from conf.face.portrait.patch_mapping import PatchMapping
from conf.face.portrait.photo_mesh import signed_areas
from conf.face.portrait.warp import PortraitWarp
from tests.support.synthetic_portrait import face_shape

SIZE = (100, 80)
WARP = PortraitWarp(face_shape())


def to_patch(flat: np.ndarray) -> np.ndarray:
    """Return where places in cm lie in a patch, 0 to 1, cut out with square pixels."""
    return np.asarray(flat * 8.0 * (1, -1) + (50.0, 16.0)) / SIZE


def test_a_patch_cut_from_the_photograph_lies_where_it_was_cut() -> None:
    sprite = PatchMapping(MOUTH, WARP)
    placed = sprite.map_vertices(to_patch(WARP.positions_cm[list(MOUTH.points)]), SIZE)
    seen = sprite.weights > 0
    np.testing.assert_allclose(placed[seen], to_patch(WARP.positions_cm[seen]), atol=5e-3)


def test_lips_that_cross_in_a_patch_are_not_drawn_turned_over() -> None:
    points = to_patch(WARP.positions_cm[list(MOUTH.points)])
    points[MOUTH.points.index(CONTROL_POINT_INDEX["inner_lip_upper_mid"]), 1] += 0.25
    upright = PatchMapping(MOUTH, WARP).map_vertices(points, SIZE) * SIZE * (1, -1)
    assert signed_areas(upright, WARP.mesh.triangles).min() > 0
