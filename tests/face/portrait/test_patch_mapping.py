import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.patch_features import MOUTH
from conf.face.portrait.patch_mapping import PatchMapping
from conf.face.portrait.photo_mesh import signed_areas
from conf.face.portrait.warp import PortraitWarp
from tests.support.synthetic_portrait import face_shape

SIZE = (100, 80)
WARP = PortraitWarp(face_shape())


def to_patch(positions_cm: np.ndarray) -> np.ndarray:
    """Return positions in a patch, 0 to 1, with 8 square pixels for each cm."""
    return np.asarray(positions_cm * 8.0 * (1, -1) + (50.0, 16.0)) / SIZE


def test_a_patch_cropped_from_the_photo_maps_to_the_crop() -> None:
    mapping = PatchMapping(MOUTH, WARP)
    mapped = mapping.map_vertices(to_patch(WARP.positions_cm[list(MOUTH.points)]), SIZE)
    visible = mapping.weights > 0
    np.testing.assert_allclose(mapped[visible], to_patch(WARP.positions_cm[visible]), atol=5e-3)


@pytest.mark.slow
def test_lips_that_cross_in_a_patch_cause_no_folds() -> None:
    points = to_patch(WARP.positions_cm[list(MOUTH.points)])
    points[MOUTH.points.index(CONTROL_POINT_INDEX["inner_lip_upper_mid"]), 1] += 0.25
    upright = PatchMapping(MOUTH, WARP).map_vertices(points, SIZE) * SIZE * (1, -1)
    assert signed_areas(upright, WARP.mesh.triangles).min() > 0
