import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, control_point_indices
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.face.portrait.lip_lid_gaps import height_at
from conf.face.portrait.warp import PortraitWarp
from conf.receiver.portrait.shut_lids import ShutLid, predict_shut_lids
from tests.support.synthetic_portrait import POSE, face_shape

pytestmark = pytest.mark.slow

ABOVE, BELOW, EYE = (90, 130, 180), (110, 150, 210), (20, 25, 30)  # BGR
WIDTH, HEIGHT = 640, 480


@pytest.fixture(scope="module")
def warp() -> PortraitWarp:
    return PortraitWarp(face_shape())


@pytest.fixture(scope="module")
def lids(warp: PortraitWarp) -> tuple[ShutLid, ...]:
    return predict_shut_lids(painted_photo(warp), warp)


def painted_photo(warp: PortraitWarp) -> NDArray[np.uint8]:
    """Return a photo with skin of one colour above the eyes' corners, of another below, and with dark eyes."""
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) / HEIGHT, (np.arange(HEIGHT) + 0.5) / HEIGHT)
    positions = np.column_stack([x.ravel() - WIDTH / HEIGHT / 2, 0.5 - y.ravel()])
    level = np.mean([eye.photo.origin[1] for eye in warp.mesh.eyes])
    colours = np.where(positions[:, 1:] > level, np.array(ABOVE), np.array(BELOW))
    for eye in warp.mesh.eyes:
        colours[eye.photo.contains(positions)] = EYE
    return colours.reshape(HEIGHT, WIDTH, 3).astype(np.uint8)


def closed_by(warp: PortraitWarp, units: float) -> NDArray[np.float64]:
    """Return the mesh's positions with the upper lids lowered."""
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[control_point_indices("eyelid_upper"), 1] = -units
    return warp.deform(displacements, POSE)


def test_eyes_as_open_as_in_the_photo_are_not_covered(warp: PortraitWarp, lids: tuple[ShutLid, ...]) -> None:
    for lid in lids:
        vertices, opacity = lid.grid(warp.mesh.positions)
        assert opacity == 0 and len(vertices) == 0


def test_lids_become_opaque_steadily(warp: PortraitWarp, lids: tuple[ShutLid, ...]) -> None:
    for lid in lids:
        opacities = [lid.grid(closed_by(warp, u))[1] for u in np.linspace(0, UNITS_PER_DISTANCE, 120)]
        assert opacities[0] == 0 and opacities[-1] == 1
        assert (np.diff(opacities) >= 0).all() and np.diff(opacities).max() < 0.06


def test_shut_lids_have_the_colours_of_the_skin_around(lids: tuple[ShutLid, ...]) -> None:
    low, high = np.minimum(ABOVE, BELOW), np.maximum(ABOVE, BELOW)
    for lid in lids:
        skin = lid.colours[40:60, 8:-8]
        assert (skin >= low - 3).all() and (skin <= high + 3).all()
        assert (lid.alpha[40:48, 8:-8] > 240).all()


def test_the_lash_line_is_as_dark_as_the_edge_of_the_eye(lids: tuple[ShutLid, ...]) -> None:
    for lid in lids:
        dark = (lid.colours.max(axis=2) < max(EYE) + 25) & (lid.alpha > 200)
        assert (dark[:, 8:16].any(axis=0)).all()
        assert 3 < dark[:, 12].sum() < 25


def test_a_lid_fades_towards_all_sides(lids: tuple[ShutLid, ...]) -> None:
    for lid in lids:
        border = np.concatenate([lid.alpha[0], lid.alpha[-1], lid.alpha[:, 0], lid.alpha[:, -1]])
        assert border.max() < 12


def test_the_grid_covers_what_has_closed(warp: PortraitWarp, lids: tuple[ShutLid, ...]) -> None:
    positions = closed_by(warp, UNITS_PER_DISTANCE)
    for lid in lids:
        vertices, _ = lid.grid(positions)
        assert vertices.shape == lid.uvs.shape and lid.triangles.max() < len(vertices)
        photo = lid.eye.photo
        x, height = photo.coordinates(vertices)
        middle = np.abs(x - photo.length / 2) < photo.length / 8
        assert height[middle].max() > height_at(photo.upper, np.array([photo.length / 2]))[0]
        assert height[middle].min() < height_at(photo.lower, np.array([photo.length / 2]))[0]


def test_positions_are_finite_whatever_the_mesh(warp: PortraitWarp, lids: tuple[ShutLid, ...]) -> None:
    for seed in range(20):
        positions = np.random.default_rng(seed).uniform(-1, 1, warp.mesh.positions.shape)
        for lid in lids:
            for mesh in (positions, np.zeros_like(positions)):
                assert np.isfinite(lid.grid(mesh)[0]).all()
