"""Lip lines and lid edges on bent sheets whose shape is known."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.mesh.depth_profiles import LabelledMesh, find_lid_edge, find_lip_line

ROWS = np.arange(-2.0, 2.0001, 0.05)


def sheet(
    depth: Callable[[NDArray[np.float64]], NDArray[np.float64]], rows: NDArray[np.float64] = ROWS
) -> LabelledMesh:
    """Return a sheet that is as deep at each height as `depth` says, the same across."""
    x, y = np.meshgrid([-1.0, 1.0], rows)
    vertices = np.stack([x.ravel(), y.ravel(), np.repeat(depth(rows), 2)], axis=1)
    first = 2 * np.arange(len(rows) - 1)
    triangles = np.concatenate([np.stack([first, first + 1, first + 3], 1), np.stack([first, first + 3, first + 2], 1)])
    return LabelledMesh(vertices, triangles.astype(np.int32), np.zeros(len(triangles), np.int32))


def joined(*parts: LabelledMesh) -> LabelledMesh:
    """Return several sheets, each a component of its own."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return LabelledMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=False)]).astype(np.int32),
        np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.triangles) for part in parts]),
    )


def lips(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two bulges of 3 mm that meet at 0.2."""
    return 0.3 * np.sin(np.clip(np.abs(y - 0.2) * np.pi / 0.8, 0, np.pi))


def test_the_line_between_closed_lips_is_the_crease() -> None:
    line = find_lip_line(sheet(lips), np.array([0.1, 0.0, 0.2]))
    assert line is not None
    for point in line:
        assert point[1] == pytest.approx(0.2, abs=0.05)
        assert point[2] == pytest.approx(0.0, abs=0.05)


def test_open_lips_end_at_the_edges_of_the_gap() -> None:
    upper, lower = sheet(lips, ROWS[ROWS > 0.39]), sheet(lips, ROWS[ROWS < 0.06])
    line = find_lip_line(joined(upper, lower), np.array([0.0, 0.0, 0.2]))
    assert line is not None
    assert line[0][1] == pytest.approx(0.40, abs=0.05)
    assert line[1][1] == pytest.approx(0.05, abs=0.05)


def test_a_flat_sheet_has_no_lips() -> None:
    assert find_lip_line(sheet(np.zeros_like), np.array([0.0, 0.0, 0.0])) is None


def test_the_lid_edge_is_where_the_eyeball_begins() -> None:
    skin = [sheet(np.zeros_like, ROWS[ROWS > 0.44]), sheet(np.zeros_like, ROWS[ROWS < -0.34])]
    eye = sheet(lambda y: np.full_like(y, -0.03))
    face = joined(*skin, eye)
    upper = find_lid_edge(face, np.array([0.0, 0.6, 0.0]), 0.0)
    lower = find_lid_edge(face, np.array([0.0, -0.3, 0.0]), 0.0)
    assert upper is not None and lower is not None
    np.testing.assert_allclose(upper, [0.0, 0.45, 0.0], atol=0.03)
    np.testing.assert_allclose(lower, [0.0, -0.35, 0.0], atol=0.03)


def test_the_lid_edge_is_found_at_an_empty_socket() -> None:
    face = sheet(np.zeros_like, ROWS[ROWS > 0.44])
    edge = find_lid_edge(face, np.array([0.0, 0.5, 0.0]), 0.0)
    assert edge is not None
    assert edge[1] == pytest.approx(0.45, abs=0.03)


def test_a_closed_smooth_eye_has_no_edge() -> None:
    assert find_lid_edge(sheet(lambda y: -0.05 * y * y), np.array([0.0, 0.5, 0.0]), 0.0) is None
