"""The triangles of a textured grid, and colours in linear light."""

import numpy as np
import pytest

from conf.receiver.portrait.textured_grid import grid_triangles, to_linear, to_srgb


def test_triangles_cover_each_cell_of_the_grid_once() -> None:
    triangles = grid_triangles(3, 4)
    points = np.stack(np.meshgrid(np.arange(4.0), np.arange(3.0)), axis=-1).reshape(-1, 2)
    (ax, ay), (bx, by) = (np.moveaxis(points[triangles[:, i]] - points[triangles[:, 0]], -1, 0) for i in (1, 2))
    np.testing.assert_allclose(np.abs(ax * by - ay * bx) / 2, 0.5)
    assert len(triangles) == 2 * 2 * 3 and len({tuple(sorted(t)) for t in triangles.tolist()}) == len(triangles)


def test_linear_light_returns_to_srgb() -> None:
    levels = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(to_srgb(to_linear(levels)), levels)
    assert to_linear(np.array([128], np.uint8))[0] == pytest.approx(0.22, abs=0.005)
