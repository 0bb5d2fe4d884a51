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


def test_the_prediction_with_the_photos_points_is_the_photo() -> None:
    photo = ramp(60, 40)
    np.testing.assert_allclose(predict_patch(photo, CORNERS, CORNERS, (60, 40)), photo, atol=0.5)


def test_the_prediction_follows_the_points() -> None:
    photo = ramp(60, 40)
    crop = (CORNERS - (0.25, 0.25)) * 2  # the same points in a crop of the middle of the photo
    predicted = predict_patch(photo, CORNERS, crop, (30, 20))
    np.testing.assert_allclose(predicted[5:15, 5:25], photo[15:25, 20:40], atol=1.5)


def test_coincident_points_are_an_error_or_yield_finite_pixels() -> None:
    try:
        assert np.isfinite(predict_patch(ramp(60, 40), CORNERS, CORNERS * 0, (30, 20))).all()
    except ValueError:
        pass


@pytest.mark.parametrize("size", [(48, 40), (33, 17), (1, 1)])
def test_the_inverse_dct_restores_the_residual(size: tuple[int, int]) -> None:
    smooth = ramp(*size).astype(float) - 60
    assert [plane.shape for plane in forward_dct(smooth)] == plane_shapes(*size), "as in WIRE.md"
    np.testing.assert_allclose(inverse_dct(forward_dct(smooth), size), smooth, atol=4)
    grey = np.repeat(np.random.default_rng(0).normal(0, 30, (size[1], size[0], 1)), 3, axis=2)
    np.testing.assert_allclose(inverse_dct(forward_dct(grey), size), grey, atol=1e-3)


def test_low_frequencies_come_first() -> None:
    flat, *chroma = forward_dct(np.full((16, 16, 3), 12.0))
    assert flat.shape == (2, 2, 64) and np.allclose(flat[..., 1:], 0) and np.allclose(flat[..., 0], 96)
    assert all(np.allclose(plane, 0, atol=1e-3) for plane in chroma)


@pytest.mark.slow
def test_points_in_the_photo_are_those_of_the_mesh() -> None:
    warp = PortraitWarp(face_shape())
    points, positions = region_points_in_photo(warp, MOUTH), warp.mesh.positions[list(MOUTH.points)]
    assert points.shape == (len(MOUTH.points), 2)
    np.testing.assert_allclose((points - 0.5) * (warp.shape.aspect, -1), positions, atol=1e-12)
