import numpy as np
import pytest
from PIL import Image

from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.fitting.default_texture import (
    COLOUR_UVS,
    EYE_ARC,
    EYE_UV,
    EYE_UV_RADII,
    TEXTURE_FILE,
    apply_default_texture,
)
from conf.face.mesh.mesh import Mesh, load_mesh


@pytest.fixture(scope="module")
def head() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.fixture(scope="module")
def painted(head: Mesh) -> Mesh:
    return apply_default_texture(head, default_points(), default_joints().eyes)


def uvs_of(mesh: Mesh, group: str) -> np.ndarray:
    return mesh.uvs[np.unique(mesh.render_triangles[mesh.groups[group]])]


def test_the_surface_stays_as_it_is(head: Mesh, painted: Mesh) -> None:
    assert painted.vertices is head.vertices
    assert painted.render_vertices[painted.render_triangles].tolist() == head.triangles.tolist()


@pytest.mark.parametrize(
    ("group", "colour"),
    [("skin", "skin"), ("hair", "skin"), ("teeth_upper", "teeth"), ("tongue", "tongue"), ("mouth", "mouth")],
)
def test_each_part_has_its_colour(painted: Mesh, group: str, colour: str) -> None:
    assert np.unique(uvs_of(painted, group), axis=0).tolist() == [list(COLOUR_UVS[colour])]


def test_the_iris_is_where_the_pupil_is_and_as_large_as_on_a_head(head: Mesh, painted: Mesh) -> None:
    rows = np.unique(painted.render_triangles[painted.groups["eye_l"]])
    places = painted.vertices[painted.render_vertices[rows]]
    pupil = default_points()[16]
    off = (painted.uvs[rows] - EYE_UV) / EYE_UV_RADII
    nearest = np.linalg.norm(places - pupil, axis=1).argmin()
    assert off[nearest] == pytest.approx([0, 0], abs=0.03)
    around = np.linalg.norm((places - pupil)[:, :2], axis=1) < 0.6
    assert np.hypot(*off[around].T) * EYE_ARC == pytest.approx(np.hypot(*(places - pupil)[around, :2].T), abs=0.06)
    right = places[:, 0] > pupil[0] + 0.2
    assert (off[right, 0] > 0).all()  # what lies to the left of the subject lies to the right of the picture


def test_the_picture_has_a_dark_pupil_and_a_light_white() -> None:
    with Image.open(TEXTURE_FILE) as picture:
        colours = np.asarray(picture.convert("RGB"), dtype=float)
    height, width, _ = colours.shape

    def at(u: float, v: float) -> np.ndarray:
        return np.asarray(colours[int((1 - v) * height), int(u * width)])

    assert at(*EYE_UV).mean() < 30
    assert at(*(EYE_UV + EYE_UV_RADII * [0.5, 0])).mean() > 180
    assert at(*COLOUR_UVS["skin"])[0] > at(*COLOUR_UVS["mouth"])[0] + 50
