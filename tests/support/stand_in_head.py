"""A small head built without files, and an offscreen window."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINTS
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

SIZE = (320, 240)
SKULL = (np.array([0.0, 1.0, -2.0]), np.array([7.0, 9.5, 7.0]))  # centre and radii, cm
EYE_RADIUS = 1.2

# Positions of the control points by prefix, x to the subject's left, y up, cm; the right side mirrors the left.
POSITIONS = {
    "chin": (0.8, -7.0), "inner_lip_upper": (0.5, -3.6), "inner_lip_lower": (0.5, -4.0),
    "inner_lip_corner": (2.2, -3.8), "outer_lip_upper": (0.8, -3.0), "outer_lip_lower": (0.8, -4.8),
    "outer_lip_corner": (2.5, -3.8), "cupids": (0.4, -2.9),
    "eyelid_upper": (3.2, 3.1), "eyelid_lower": (3.2, 2.1), "pupil": (3.2, 2.6), "eye_outer": (4.4, 2.6),
    "eye_inner": (2.0, 2.6), "eye_lower": (3.2, 1.6), "eye_upper": (3.2, 3.6), "brow_inner": (1.5, 4.4),
    "brow_top": (3.2, 4.8), "brow_outer": (4.8, 4.2), "cheek_center": (3.2, -1.2), "cheekbone": (4.8, 0.6),
    "nostril": (1.4, -0.8), "nose_bottom": (0.7, -1.4),
}  # fmt: skip


def ball(centre: NDArray[np.float64], radii: NDArray[np.float64] | float, count: int) -> NDArray[np.float64]:
    """Return the vertices of an ellipsoid, in rows from the south pole to the north pole."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, count // 2 + 1)
    longitude = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    y, x = np.meshgrid(latitude, longitude, indexing="ij")
    unit = np.stack([np.cos(y) * np.sin(x), np.sin(y), np.cos(y) * np.cos(x)], axis=-1)
    return (centre + radii * unit).reshape(-1, 3)


def ball_triangles(count: int) -> NDArray[np.int64]:
    """Return the triangles of `ball`, counter-clockwise from outside; those at the poles are degenerate."""
    rows, columns = np.meshgrid(np.arange(count // 2), np.arange(count), indexing="ij")
    a, b = (rows * count + columns).ravel(), (rows * count + (columns + 1) % count).ravel()
    return np.concatenate([np.stack([a, b, b + count], axis=1), np.stack([a, b + count, a + count], axis=1)])


def on_skull(x: float, y: float) -> tuple[float, float, float]:
    """Return the (3,) point of the front of the skull at x, y, cm."""
    centre, radii = SKULL
    u, v = (x - centre[0]) / radii[0], (y - centre[1]) / radii[1]
    return x, y, float(centre[2] + radii[2] * np.sqrt(1 - u * u - v * v))


def control_points() -> NDArray[np.float64]:
    """Return the (50, 3) control points, cm."""
    points = []
    for point in CONTROL_POINTS:
        x, y = next(position for prefix, position in POSITIONS.items() if point.name.startswith(prefix))
        side = {"l": 1.0, "r": -1.0}.get(point.name.rsplit("_", 1)[1], 0.0)
        points.append(on_skull(side * x, y))
    return np.array(points)


def stand_in_mesh() -> Mesh:
    """Return a mesh of skin, two eyeballs, a tongue and hair."""
    centre, radii = SKULL
    balls: dict[str, tuple[NDArray[np.float64], NDArray[np.float64] | float]] = {
        "skin": (centre, radii),
        "eye_l": (np.array([3.2, 2.6, 3.8]), EYE_RADIUS),
        "eye_r": (np.array([-3.2, 2.6, 3.8]), EYE_RADIUS),
        "tongue": (np.array([0.0, -3.8, 2.0]), 1.0),
    }
    positions: list[NDArray[np.float64]] = []
    corners: list[NDArray[np.int64]] = []
    groups, count = {}, 24
    for name, (position, radius) in balls.items():
        first, start = sum(map(len, positions)), sum(map(len, corners))
        positions.append(ball(position, radius, count))
        corners.append(ball_triangles(count) + first)
        groups[name] = np.arange(start, start + len(corners[-1]))
    triangles = np.concatenate(corners)
    skull = ball_triangles(count)
    positions.append(ball(centre, radii * 1.06, count))
    crown = skull[(positions[-1][skull][..., 1] > 6.0).all(axis=1)]
    groups["hair"] = np.arange(len(triangles), len(triangles) + len(crown))
    triangles = np.concatenate([triangles, crown + sum(map(len, positions[:-1]))])
    no_uv = np.full_like(triangles, -1)
    return build_mesh(
        RawMesh(np.concatenate(positions), np.empty((0, 2)), np.stack([triangles, no_uv], axis=2), groups, None)
    )


@pytest.fixture(scope="session")
def face() -> FaceModel:
    """Return a face whose operator is zero."""
    mesh, points = stand_in_mesh(), control_points()
    return FaceModel(mesh, points, np.zeros((len(mesh.vertices), len(points)), np.float32))


@pytest.fixture
def window(gl: None) -> Iterator[OffscreenWindow]:
    """Yield an offscreen window of SIZE pixels."""
    with OffscreenWindow(*SIZE) as window:
        yield window


@pytest.fixture
def overlay(window: OffscreenWindow) -> Iterator[ImGuiOverlay]:
    """Yield an ImGui overlay on the offscreen window."""
    overlay = ImGuiOverlay(window.ctx)
    yield overlay
    overlay.release()
