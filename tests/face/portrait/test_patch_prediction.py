import numpy as np
import pytest

from conf.face.portrait.patch_features import MOUTH
from conf.face.portrait.patch_prediction import forward_dct, inverse_dct, predict_patch, region_points_in_photo
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.dct_coding import plane_shapes
from tests.support.synthetic_portrait import face_shape

CORNERS = np.array([(0.1, 0.1), (0.9, 0.1), (0.1, 0.9), (0.9, 0.9), (0.5, 0.5), (0.4, 0.7)])


def ramp(width: int, height: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    return np.stack([x * 2, y * 3, x + y], axis=-1).astype(np.uint8)


def test_a_patch_with_the_photographs_points_is_foretold_as_the_photograph() -> None:
    photo = ramp(60, 40)
    np.testing.assert_allclose(predict_patch(photo, CORNERS, CORNERS, (60, 40)), photo, atol=0.5)


def test_what_moves_is_foretold_where_its_points_are() -> None:
    photo = ramp(60, 40)
    part = (CORNERS - (0.25, 0.25)) * 2  # the same points in the middle of the photograph, cut out
    foretold = predict_patch(photo, CORNERS, part, (30, 20))
    np.testing.assert_allclose(foretold[5:15, 5:25], photo[15:25, 20:40], atol=1.5)


def test_points_that_all_coincide_are_an_error_or_finite() -> None:
    try:
        assert np.isfinite(predict_patch(ramp(60, 40), CORNERS, CORNERS * 0, (30, 20))).all()
    except ValueError:
        pass


@pytest.mark.parametrize("size", [(48, 40), (33, 17), (1, 1)])
def test_a_difference_comes_back_from_its_coefficients(size: tuple[int, int]) -> None:
    smooth = ramp(*size).astype(float) - 60
    assert [plane.shape for plane in forward_dct(smooth)] == plane_shapes(*size), "what the wire expects"
    np.testing.assert_allclose(inverse_dct(forward_dct(smooth), size), smooth, atol=4)
    grey = np.repeat(np.random.default_rng(0).normal(0, 30, (size[1], size[0], 1)), 3, axis=2)
    np.testing.assert_allclose(inverse_dct(forward_dct(grey), size), grey, atol=1e-3)


def test_low_frequencies_come_first() -> None:
    flat, *tints = forward_dct(np.full((16, 16, 3), 12.0))
    assert flat.shape == (2, 2, 64) and np.allclose(flat[..., 1:], 0) and np.allclose(flat[..., 0], 96)
    assert all(np.allclose(tint, 0, atol=1e-3) for tint in tints)


def test_the_photographs_points_are_where_its_mesh_has_them() -> None:
    warp = PortraitWarp(face_shape())
    points, places = region_points_in_photo(warp, MOUTH), warp.mesh.positions[list(MOUTH.points)]
    assert points.shape == (len(MOUTH.points), 2)
    np.testing.assert_allclose((points - 0.5) * (warp.shape.aspect, -1), places, atol=1e-12)
