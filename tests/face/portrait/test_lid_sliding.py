import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.eyelid_closure import EyeOpening
from conf.face.portrait.lid_sliding import LidSliding
from conf.face.portrait.patch_features import EYES
from conf.face.portrait.patch_prediction import PatchPredictor, region_points_in_photo
from conf.face.portrait.warp import PortraitWarp
from tests.support.synthetic_portrait import face_shape

pytestmark = pytest.mark.slow

SKIN, WHITE = 180, 40
WIDTH, HEIGHT = 640, 480
LOW, HIGH = np.array([0.3, 0.25]), np.array([0.8, 0.6])  # the crop of the patch
SIZE = (96, 51)


@pytest.fixture(scope="module")
def warp() -> PortraitWarp:
    return PortraitWarp(face_shape())


def painted_photo(warp: PortraitWarp) -> NDArray[np.uint8]:
    """Return a photo of plain skin with dark eyes."""
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) / HEIGHT, (np.arange(HEIGHT) + 0.5) / HEIGHT)
    positions = np.column_stack([x.ravel() - WIDTH / HEIGHT / 2, 0.5 - y.ravel()])
    inside = np.any([eye.photo.contains(positions) for eye in warp.mesh.eyes], axis=0)
    return np.repeat(np.where(inside, WHITE, SKIN).reshape(HEIGHT, WIDTH, 1), 3, axis=2).astype(np.uint8)


def patch_points(warp: PortraitWarp, closure: float) -> NDArray[np.float64]:
    """Return the eyes' control points in the patch, with the upper lids lowered by `closure` of the gap."""
    points = (region_points_in_photo(warp, EYES) - LOW) / (HIGH - LOW)
    rows = {point: row for row, point in enumerate(EYES.points)}
    for side in "lr":
        upper, lower = (rows[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"]] for lid in ("upper", "lower"))
        points[upper] += closure * (points[lower] - points[upper])
    return points


def test_a_shut_lid_is_predicted_from_skin(warp: PortraitWarp) -> None:
    predictor = PatchPredictor(painted_photo(warp), warp)
    is_open, is_shut = (predictor.predict(EYES, patch_points(warp, closure), SIZE) for closure in (0.0, 1.0))
    dark = [int((image[..., 0] < (SKIN + WHITE) / 2).sum()) for image in (is_open, is_shut)]
    assert dark[0] > 50 and dark[1] < 0.5 * dark[0], dark


def test_open_lids_stay_with_the_spline(warp: PortraitWarp) -> None:
    pixels = np.random.default_rng(1).uniform(0, SIZE, (400, 2))
    sources = LOW + pixels / SIZE * (HIGH - LOW)
    slid = LidSliding(warp).slide(sources, pixels, patch_points(warp, 0.0), SIZE)
    np.testing.assert_allclose(slid, sources, atol=0.004)


def test_sources_are_finite_whatever_the_points(warp: PortraitWarp) -> None:
    pixels = np.random.default_rng(1).uniform(0, SIZE, (50, 2))
    for points in np.random.default_rng(2).uniform(-1, 2, (20, len(EYES.points), 2)):
        assert np.isfinite(LidSliding(warp).slide(pixels / SIZE, pixels, points, SIZE)).all()


def test_the_eyes_of_a_mesh_are_the_openings_that_slide(warp: PortraitWarp) -> None:
    assert all(isinstance(eye, EyeOpening) for eye in warp.mesh.eyes) and len(warp.mesh.eyes) == 2
