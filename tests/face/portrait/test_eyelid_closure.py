import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.photo_mesh import build_mesh, signed_areas
from tests.support.synthetic_portrait import face_shape

MESH = build_mesh(face_shape())
PLACES = MESH.positions


def test_pupils_lie_between_the_lids_and_their_triangles_come_first() -> None:
    right, left = MESH.eyeballs
    assert CONTROL_POINT_INDEX["pupil_r"] in right.inside and CONTROL_POINT_INDEX["pupil_l"] in left.inside
    of_eyes = np.isin(MESH.triangles, [*right.rim, *left.rim]).any(axis=1)
    assert of_eyes.any() and not of_eyes[200:].any()


def test_no_triangle_joins_an_eyeball_to_the_edge_that_slides_over_it() -> None:
    for eyeball in MESH.eyeballs:
        of_eyeball = np.isin(MESH.triangles, [*eyeball.rim, *eyeball.inside]).any(axis=1)
        assert not np.isin(MESH.triangles[of_eyeball], eyeball.upper[1:-1]).any()


def test_open_eyes_are_left_alone() -> None:
    same = PLACES.copy()
    for eyeball in MESH.eyeballs:
        eyeball.apply(same)
    np.testing.assert_allclose(same, PLACES)


def test_a_lid_shuts_all_along_and_leaves_the_eyeball_as_it_is() -> None:
    shut = PLACES.copy()
    for eyeball in MESH.eyeballs:
        middle = len(eyeball.upper) // 2
        shut[eyeball.upper[middle], 1] = shut[eyeball.lower[middle], 1] + 1e-3
        eyeball.apply(shut)
        gaps, before = ((p[eyeball.upper, 1] - p[eyeball.lower, 1])[1:-1] for p in (shut, PLACES))
        assert (gaps < 0.5 * before).all()
        np.testing.assert_allclose(shut[eyeball.inside], PLACES[eyeball.inside], atol=6e-3)
        np.testing.assert_allclose(shut[eyeball.rim], PLACES[eyeball.rim], atol=6e-3)
    assert signed_areas(shut, MESH.triangles).min() > 0
