import numpy as np
import pytest

from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace


def strip(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a strip of unit squares along x: vertices 2i and 2i + 1 at x = i."""
    vertices = np.array([[i, j, 0.0] for i in range(count) for j in range(2)])
    triangles = [t for i in range(0, 2 * count - 2, 2) for t in ([i, i + 2, i + 1], [i + 1, i + 2, i + 3])]
    return vertices, np.array(triangles, dtype=np.int32)


def split_corners(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface with separate vertices for each triangle, as in STL files."""
    return vertices[triangles.ravel()], np.arange(triangles.size, dtype=np.int32).reshape(-1, 3)


def test_distances_run_along_the_edges() -> None:
    surface = SurfaceGraph(*strip(6))
    assert surface.distances(np.array([0]), limit=100)[[0, 2, 4, 10]] == pytest.approx([0, 1, 2, 5])


def test_distances_are_limited() -> None:
    assert SurfaceGraph(*strip(6)).distances(np.array([0]), limit=2.5).max() == 2.5


def test_distances_are_to_the_nearest_seed() -> None:
    assert SurfaceGraph(*strip(6)).distances(np.array([0, 10]), limit=100)[[2, 8]] == pytest.approx([1, 1])


def test_coinciding_vertices_of_different_triangles_are_joined() -> None:
    vertices, triangles = strip(6)
    loose = split_corners(vertices, triangles)
    distances = SurfaceGraph(*loose).distances(np.array([0]), limit=100)
    assert distances == pytest.approx(
        SurfaceGraph(vertices, triangles).distances(np.array([0]), limit=100)[triangles.ravel()]
    )


@pytest.mark.slow
def test_repeated_vertices_do_not_change_distances(face: SheetFace) -> None:
    whole = SurfaceGraph(face.mesh.vertices, face.mesh.triangles).distances(np.array([500]), limit=9.0)
    loose = SurfaceGraph(*split_corners(face.mesh.vertices, face.mesh.triangles))
    start = int(np.flatnonzero(face.mesh.triangles.ravel() == 500)[0])
    distances = loose.distances(np.array([start]), limit=9.0)
    assert distances == pytest.approx(whole[face.mesh.triangles.ravel()], abs=1e-9)


def test_closed_surfaces_that_touch_are_not_joined() -> None:
    box = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])])
    both = SurfaceGraph(
        np.concatenate([box, box + np.array([1, 0, 0])]), np.concatenate([triangles, triangles + 8]).astype(np.int32)
    )
    assert both.distances(np.array([0]), limit=50.0)[8:].min() == 50.0


def test_the_skin_is_preferred_to_nearer_lashes() -> None:
    vertices, triangles = strip(6)
    lash = np.array([[2, 0.0, 0.2], [2.2, 0, 0.2], [2, 0.2, 0.2]])
    surface = SurfaceGraph(
        np.concatenate([vertices, lash]), np.concatenate([triangles, [[12, 13, 14]]]).astype(np.int32)
    )
    positions = np.array([[0, 0, 0], [2, 0, 0.15], [5, 1, 0]])
    assert surface.nearest_vertices(positions, tolerance=0.3).tolist() == [0, 4, 11]
    assert surface.nearest_vertices(positions, tolerance=0.0).tolist() == [0, 12, 11]


def test_loose_parts_belong_to_the_nearest_skin() -> None:
    vertices, triangles = strip(6)
    lash = np.array([[2, -0.1, 0.2], [2.2, -0.1, 0.2], [2, -0.2, 0.2]])
    surface = SurfaceGraph(
        np.concatenate([vertices, lash]), np.concatenate([triangles, [[12, 13, 14]]]).astype(np.int32)
    )
    parents = surface.parent_vertices(np.array([0]))
    assert parents[:12].tolist() == list(range(12))
    assert parents[12:].tolist() == [4, 4, 4]


@pytest.mark.parametrize(
    "triangles", [[[0, 0, 0]], [[0, 1, 1]], [[0, 1, 2], [0, 1, 2]]], ids=["point", "edge", "twice"]
)
def test_degenerate_triangles_give_finite_distances(triangles: list[list[int]]) -> None:
    surface = SurfaceGraph(np.zeros((4, 3)), np.array(triangles, dtype=np.int32))
    assert np.isfinite(surface.distances(np.array([0]), limit=1.0)).all()
