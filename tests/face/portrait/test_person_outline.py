import numpy as np

from conf.face.portrait.person_outline import BORDER_EXTENSION, extend_outline, triangles_on_person

SQUARE = np.array([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)])


def test_triangles_near_the_person_are_kept() -> None:
    positions = np.array(
        [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.5, 0.5), (0.6, 0.5), (0.5, 0.6), (0.21, 0.0), (0.3, 0.1)]
    )
    triangles = np.array([(0, 1, 2), (3, 4, 5), (6, 7, 3), (0, 6, 7)], dtype=np.int32)
    np.testing.assert_array_equal(triangles_on_person(positions, triangles, SQUARE, 0.01), [True, False, True, True])
    assert triangles_on_person(positions, triangles, SQUARE[:2], 0.01).all()


def test_outline_points_at_the_border_are_moved_beyond_it() -> None:
    outline = np.array([(-0.3, -0.5), (0.66, 0.0), (0.1, 0.3)])
    np.testing.assert_allclose(
        extend_outline(outline, 4 / 3), [(-0.3, -0.5 - BORDER_EXTENSION), (2 / 3 + BORDER_EXTENSION, 0.0), (0.1, 0.3)]
    )
