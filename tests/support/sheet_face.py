"""A small analytic face: a curved sheet with a slit for the mouth and the fifty control points on it."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh

# x and y in cm of each control point, in the order of control_points.py, on a mean face with its mouth a little open.
_POSITIONS = """
0 -9.4, 0 -4.0, 0 -4.6, 2.2 -4.3, -2.2 -4.3, 1.0 -4.0, -1.0 -4.0, 1.1 -4.6, -1.1 -4.6, 0 -7.9, 2.3 -9.0, -2.3 -9.0,
3.2 3.0, -3.2 3.0, 3.2 2.3, -3.2 2.3, 3.2 2.6, -3.2 2.6, 4.4 2.7, -1.9 2.6, 3.2 2.0, -3.2 2.0, 1.9 2.6, -4.4 2.7,
3.2 3.3, -3.2 3.3, 1.4 5.0, -1.4 5.0, 4.0 5.1, -4.0 5.1, 5.7 4.3, -5.7 4.3, 3.8 -1.5, -3.8 -1.5, 4.8 -0.7, -4.8 -0.7,
0 -3.4, 0 -5.4, 2.5 -4.3, -2.5 -4.3, 1.4 -3.5, -1.4 -3.5, 1.3 -5.1, -1.3 -5.1, -0.7 -3.3, 0.7 -3.3, 1.8 -1.0,
-1.8 -1.0, -1.4 -1.7, 1.4 -1.7
"""
_STEP = 0.3
_SLIT = (2.2, -4.5, -4.1)  # half width, bottom and top of the mouth: triangles inside are removed


@dataclass(frozen=True)
class SheetFace:
    """A mesh and the (n, 3) control points on it, cm."""

    mesh: Mesh
    points: NDArray[np.float64]


def surface_z(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return z of the sheet, cm."""
    return 6.0 - 0.05 * x**2 - 0.02 * y**2


def sheet_face(*, slit: bool) -> SheetFace:
    """Build the sheet, with a slit for the mouth or without."""
    xs, ys = np.arange(-12, 12.01, _STEP), np.arange(-14, 13.01, _STEP)
    x, y = (grid.ravel() for grid in np.meshgrid(xs, ys))
    vertices = np.stack([x, y, surface_z(x, y)], axis=1)
    corner = (np.arange(len(ys) - 1)[:, None] * len(xs) + np.arange(len(xs) - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + len(xs) + 1, corner + len(xs)], axis=1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    if slit:
        x, y, _ = vertices[triangles].mean(axis=1).T
        inside = (np.abs(x) < _SLIT[0]) & (y > _SLIT[1]) & (y < _SLIT[2])
        triangles = triangles[~inside]
    corners = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    mesh = build_mesh(RawMesh(vertices, np.empty((0, 2)), corners, {"skin": np.arange(len(triangles))}, None))
    positions = np.array(_POSITIONS.replace(",", " ").split(), dtype=np.float64).reshape(CONTROL_POINT_COUNT, 2)
    return SheetFace(mesh, np.column_stack([positions, surface_z(*positions.T)]))


@pytest.fixture(scope="session")
def face() -> SheetFace:
    """Return a sheet with a mouth that can open."""
    return sheet_face(slit=True)


@pytest.fixture(scope="session")
def shut_face() -> SheetFace:
    """Return a sheet without a mouth opening."""
    return sheet_face(slit=False)
