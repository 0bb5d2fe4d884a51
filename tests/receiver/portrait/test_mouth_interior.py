import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, control_point_indices
from conf.face.portrait.lip_lid_gaps import OPENINGS
from conf.face.portrait.warp import PortraitWarp
from conf.receiver.portrait.mouth_interior import MouthInterior, predict_mouth_interior
from tests.support.synthetic_portrait import POSE, face_shape

pytestmark = pytest.mark.slow

SKIN = (110, 150, 210)  # BGR


@pytest.fixture(scope="module")
def warp() -> PortraitWarp:
    return PortraitWarp(face_shape())


def interior(warp: PortraitWarp, skin: tuple[int, int, int] = SKIN) -> MouthInterior:
    return predict_mouth_interior(np.full((480, 640, 3), skin, np.uint8), warp)


def opened(warp: PortraitWarp) -> NDArray[np.float64]:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] = -800
    return warp.deform(displacements, POSE)


def test_teeth_are_brighter_than_the_gap_and_the_tongue(warp: PortraitWarp) -> None:
    middle = interior(warp).colours[:, 12:20].astype(float).mean(axis=(1, 2))
    assert middle[10:14].min() > 110 > 70 > middle[19] and middle[19] < middle[28] < 120


def test_teeth_have_the_colour_of_the_light(warp: PortraitWarp) -> None:
    reddish, bluish = (interior(warp, skin).colours[12, 16].astype(int) for skin in ((90, 120, 220), (200, 150, 140)))
    assert reddish[2] - reddish[0] > 30 and bluish[0] - bluish[2] > 15
    assert reddish[2] - reddish[0] < 220 - 90  # teeth are whiter than skin


def test_a_dark_person_has_darker_teeth_than_a_lit_one(warp: PortraitWarp) -> None:
    dim, lit = (int(interior(warp, skin).colours[12, 16].max()) for skin in ((40, 50, 70), SKIN))
    assert dim < 0.5 * lit


def test_the_interior_is_between_the_lips_and_fades_at_them(warp: PortraitWarp) -> None:
    mouth, positions = interior(warp), opened(warp)
    vertices = mouth.grid(positions)
    lips = positions[OPENINGS[0][0] + OPENINGS[0][1]]
    assert vertices.shape == mouth.uvs.shape and mouth.triangles.max() < len(vertices)
    assert (vertices >= lips.min(axis=0) - 1e-9).all() and (vertices <= lips.max(axis=0) + 1e-9).all()
    assert max(mouth.alpha[0].max(), mouth.alpha[-1].max(), mouth.alpha[:, 0].max(), mouth.alpha[:, -1].max()) == 0
    assert mouth.alpha[16, 16] == 255


def test_teeth_stay_as_long_when_the_mouth_opens_wider(warp: PortraitWarp) -> None:
    mouth = interior(warp)
    rows = mouth.grid(opened(warp)).reshape(7, -1, 2)[:, 8]
    teeth, gap = np.linalg.norm(rows[3] - rows[0]), np.linalg.norm(rows[6] - rows[0])
    assert 0.1 < teeth / gap < 0.56


def test_vertices_are_finite_whatever_the_mesh(warp: PortraitWarp) -> None:
    mouth = interior(warp)
    shape = warp.mesh.positions.shape
    for positions in (np.zeros(shape), *(np.random.default_rng(seed).uniform(-1, 1, shape) for seed in range(20))):
        assert np.isfinite(mouth.grid(positions)).all()
