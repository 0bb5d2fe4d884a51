"""Properties of the default head that its users rely on."""

import json

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import KDTree

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.ppc import read_ppc
from conf.face.head_pose import ES0_CM
from conf.face.mesh.mesh import Mesh, load_mesh
from tools.assets.head.painting.noise import smoothstep
from tools.assets.head.raycast import distances_along
from tools.assets.head.scalp import find_hairline, polar
from tools.assets.head.unwrap import magnify

FOLDER = DEFAULT_HEAD.parent
GROUPS = set("skin mouth tongue teeth_upper teeth_lower eye_l eye_r lashes hair shirt".split())


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.fixture(scope="module")
def points() -> NDArray[np.float64]:
    return read_ppc(FOLDER / "head.ppc")


@pytest.fixture(scope="module")
def shapes() -> dict[str, NDArray[np.float64]]:
    with np.load(FOLDER / "shapes.npz") as file:
        return dict(zip(file["names"].tolist(), file["offsets"].astype(np.float64), strict=True))


def group(mesh: Mesh, name: str) -> NDArray[np.int64]:
    return np.unique(mesh.triangles[mesh.groups[name]]).astype(np.int64)


def test_files_are_small() -> None:
    sizes = [path.stat().st_size for path in FOLDER.iterdir()]
    assert max(sizes) < 1_000_000
    assert sum(sizes) < 3_000_000


def test_groups_and_texture(mesh: Mesh) -> None:
    assert set(mesh.groups) == GROUPS
    assert mesh.texture is not None
    with Image.open(mesh.texture) as atlas:
        assert atlas.size == (2048, 2048)
    assert 0 <= mesh.uvs.min() and mesh.uvs.max() <= 1


def test_control_points_lie_on_vertices(mesh: Mesh, points: NDArray[np.float64]) -> None:
    assert points.shape == (len(CONTROL_POINTS), 3)
    distances, _ = KDTree(mesh.vertices).query(points)
    assert np.max(distances) < 0.01


def test_eye_distance_is_that_of_the_head_pose(points: NDArray[np.float64]) -> None:
    distance = np.linalg.norm(points[CONTROL_POINT_INDEX["pupil_l"]] - points[CONTROL_POINT_INDEX["pupil_r"]])
    assert distance == pytest.approx(ES0_CM, abs=0.01)


def test_control_points_are_symmetric(points: NDArray[np.float64]) -> None:
    for point in CONTROL_POINTS:
        if point.name.endswith("_l"):
            other = points[CONTROL_POINT_INDEX[point.name[:-2] + "_r"]]
            assert np.abs(points[point.index] - other * [-1, 1, 1]).max() < 0.05, point.name


def test_lips_are_closed_and_lids_open(points: NDArray[np.float64]) -> None:
    for pair in ("mid", "l", "r"):
        upper, lower = (
            points[CONTROL_POINT_INDEX[f"inner_lip_upper_{pair}"]],
            points[CONTROL_POINT_INDEX[f"inner_lip_lower_{pair}"]],
        )
        assert -0.1 < upper[1] - lower[1] < 0.02, pair
    for side in "lr":
        assert (
            0.8
            < points[CONTROL_POINT_INDEX[f"eyelid_upper_{side}"], 1]
            - points[CONTROL_POINT_INDEX[f"eyelid_lower_{side}"], 1]
            < 1.2
        )


def test_shapes_move_the_skin_and_no_rigid_parts(mesh: Mesh, shapes: dict[str, NDArray[np.float64]]) -> None:
    assert len(shapes) == 52
    rigid = np.concatenate([group(mesh, name) for name in ("eye_l", "eye_r", "teeth_upper", "teeth_lower", "hair")])
    for name, offsets in shapes.items():
        assert offsets.shape == mesh.vertices.shape, name
        assert np.abs(offsets[rigid]).max() == 0, name
        assert np.linalg.norm(offsets, axis=1).max() > 0.05, name


def test_jaw_opens_downwards(mesh: Mesh, points: NDArray[np.float64], shapes: dict[str, NDArray[np.float64]]) -> None:
    _, chin = KDTree(mesh.vertices).query(points[CONTROL_POINT_INDEX["chin_bottom"]])
    assert shapes["jawOpen"][chin][1] < -1.0


def test_closed_lids_cover_the_eyeballs(mesh: Mesh, shapes: dict[str, NDArray[np.float64]]) -> None:
    rig = json.loads((FOLDER / "rig.json").read_text())
    skin = mesh.triangles[mesh.groups["skin"]].astype(np.int64)
    angle = np.linspace(0, 2 * np.pi, 24)
    directions = np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), np.full(24, 0.954)], axis=1)
    for side, name in (("l", "eyeBlinkLeft"), ("r", "eyeBlinkRight")):
        centre = np.array(rig[f"eye_{side}"]["centre"])
        ball = np.linalg.norm(mesh.vertices[group(mesh, f"eye_{side}")] - centre, axis=1).max()
        lids = distances_along(centre, directions, mesh.vertices + shapes[name], skin, farthest=True)
        assert (lids > ball).all(), side


def test_anchors_lie_on_the_surface_and_away_from_the_face(mesh: Mesh) -> None:
    anchors = np.array(json.loads((FOLDER / "rig.json").read_text())["anchors"])
    assert len(anchors) >= 15
    distances, _ = KDTree(mesh.vertices).query(anchors)
    assert np.max(distances) < 4.0  # some are on the body below the shirt, which is not part of the head


def test_hairline_is_symmetric_and_above_the_brows() -> None:
    around, hairline = np.linspace(-np.pi, np.pi, 181), find_hairline()
    assert np.allclose(hairline(around), hairline(-around))
    _, brow, _ = polar(np.array([[0.0, 4.5, 4.5]]))
    assert hairline(np.array([0.0])) < brow


def test_magnify_keeps_the_order_of_a_line() -> None:
    line = np.stack([np.linspace(-1, 1, 401), np.zeros(401)], axis=1)
    magnified = magnify(line, [np.zeros(2)], 0.3, 2.0)
    assert (np.diff(magnified[:, 0]) > 0).all()
    with pytest.raises(ValueError, match=r"strength must be between 0 and 2\.2, got 3"):
        magnify(line, [np.zeros(2)], 0.3, 3.0)


def test_smoothstep_rises_or_falls() -> None:
    x = np.array([-1.0, 0.5, 2.0])
    assert smoothstep(0.0, 1.0, x).tolist() == [0.0, 0.5, 1.0]
    assert smoothstep(1.0, 0.0, x).tolist() == [1.0, 0.5, 0.0]
