import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.formats.polygons import clip_ears, split_concave

NOTCHED = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.5), (0.0, 2.0)]
DART = [(0.0, 0.0), (2.0, 0.0), (0.5, 0.5), (0.0, 2.0)]  # concave at its third corner


def area(points: list[tuple[float, float]]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points[:1], strict=True)) / 2


def fan(outline: list[tuple[float, float]], shift: int, plane: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the positions of a polygon in a coordinate plane and the corners of its fan, from another start."""
    flat = np.roll(np.array(outline), -shift, axis=0)
    positions = np.insert(flat, plane, 0.25, axis=1)
    numbers = [(0, i, i + 1) for i in range(1, len(outline) - 1)]
    return positions, np.stack([np.array(numbers, np.int64)] * 2, axis=-1)


@pytest.mark.parametrize("outline", [NOTCHED, DART], ids=["notched", "dart"])
@pytest.mark.parametrize("shift", range(5))
@pytest.mark.parametrize("plane", range(3))
@pytest.mark.parametrize("is_reversed", [False, True])
def test_the_triangles_of_a_concave_polygon_lie_inside_it(
    outline: list[tuple[float, float]], shift: int, plane: int, is_reversed: bool
) -> None:
    points = outline[::-1] if is_reversed else outline
    positions, corners = fan(points, shift, plane)
    split_concave(positions, corners, np.array([[0, len(outline) - 2]]))
    a, b, c = (positions[corners[:, i, 0]] for i in range(3))
    normals = np.cross(b - a, c - a)
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(area(outline))
    whole = np.cross(positions, np.roll(positions, -1, axis=0)).sum(axis=0)
    assert (normals[:, plane] * whole[plane] > 0).all()
    assert np.array_equal(corners[..., 0], corners[..., 1])  # texture coordinates go along


def test_convex_polygons_and_unusable_ones_keep_their_fans() -> None:
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    for points, spoil in ((square, False), (DART, True)):
        positions, corners = fan(points, 1 if spoil else 0, 2)
        if spoil:
            positions[2] = np.nan
        before = corners.copy()
        split_concave(positions, corners, np.array([[0, 2]]))
        assert np.array_equal(corners, before)
    corners = np.array([[[0, -1], [1, -1], [9, -1]], [[0, -1], [9, -1], [3, -1]]])
    before = corners.copy()
    split_concave(np.zeros((4, 3)), corners, np.array([[0, 2]]))
    assert np.array_equal(corners, before)


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0.2, 1.0), st.floats(0.5, 1.0)), min_size=4, max_size=20))
def test_any_star_shaped_polygon_is_covered_once(spokes: list[tuple[float, float]]) -> None:
    angles = np.cumsum([step for _, step in spokes])
    angles *= 2 * math.pi / angles[-1]
    points = [(r * math.cos(a), r * math.sin(a)) for (r, _), a in zip(spokes, angles, strict=True)]
    triangles = clip_ears(points)
    assert len(triangles) == len(points) - 2
    areas = [area([points[i] for i in triangle]) for triangle in triangles]
    assert min(areas) > -1e-9 and sum(areas) == pytest.approx(area(points))


def test_a_polygon_that_crosses_itself_gets_as_many_triangles() -> None:
    assert len(clip_ears([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])) == 2
    assert len(clip_ears([(0.0, 0.0)] * 5)) == 3
