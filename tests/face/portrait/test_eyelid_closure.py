import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.photo_mesh import build_mesh, signed_areas
from tests.support.synthetic_portrait import face_shape

MESH = build_mesh(face_shape())
POSITIONS = MESH.positions


def test_pupils_are_between_the_lids_and_their_triangles_are_first() -> None:
    right, left = MESH.eyes
    assert CONTROL_POINT_INDEX["pupil_r"] in right.inside and CONTROL_POINT_INDEX["pupil_l"] in left.inside
    in_eyes = np.asarray(np.isin(MESH.triangles, [*right.rim, *left.rim]).any(axis=1))
    assert in_eyes.any() and not in_eyes[200:].any()


def test_no_triangle_joins_the_eyeball_and_the_upper_edge() -> None:
    for eye in MESH.eyes:
        in_eye = np.isin(MESH.triangles, [*eye.rim, *eye.inside]).any(axis=1)
        assert not np.isin(MESH.triangles[in_eye], eye.upper[1:-1]).any()


def test_open_eyes_are_unchanged() -> None:
    unchanged = POSITIONS.copy()
    for eye in MESH.eyes:
        eye.apply(unchanged)
    np.testing.assert_allclose(unchanged, POSITIONS)


def test_a_closing_lid_closes_along_its_edge_and_the_eyeball_stays() -> None:
    closed = POSITIONS.copy()
    for eye in MESH.eyes:
        middle = len(eye.upper) // 2
        closed[eye.upper[middle], 1] = closed[eye.lower[middle], 1] + 1e-3
        eye.apply(closed)
        gaps, before = ((p[eye.upper, 1] - p[eye.lower, 1])[1:-1] for p in (closed, POSITIONS))
        assert (gaps < 0.5 * before).all()
        np.testing.assert_allclose(closed[eye.inside], POSITIONS[eye.inside], atol=6e-3)
        np.testing.assert_allclose(closed[eye.rim], POSITIONS[eye.rim], atol=6e-3)
    assert signed_areas(closed, MESH.triangles).min() > 0
