import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.mesh.edge_split import drop_triangles, split_edges
from conf.face.mesh.surface_graph import triangle_edges
from conf.face.mesh.winding import triangle_normals
from tests.support.sheet_face import SheetFace


def area(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> float:
    return float(np.linalg.norm(triangle_normals(vertices, triangles), axis=1).sum() / 2)


@pytest.mark.slow
def test_splitting_keeps_the_surface_and_leaves_no_gaps(face: SheetFace) -> None:
    mesh, rng = face.mesh, np.random.default_rng(1)
    edges = np.unique(np.sort(triangle_edges(mesh.triangles), axis=1), axis=0)
    edges = edges[rng.random(len(edges)) < 0.4]
    split = split_edges(mesh, edges, rng.uniform(0.2, 0.8, len(edges)))
    assert split.vertices[: len(mesh.vertices)].tolist() == mesh.vertices.tolist()
    assert len(split.vertices) == len(mesh.vertices) + len(edges)
    assert np.isclose(area(split.vertices, split.triangles), area(mesh.vertices, mesh.triangles))
    assert (triangle_normals(split.vertices, split.triangles)[:, 2] > 0).all()
    assert split.render_vertices[split.render_triangles].tolist() == split.triangles.tolist()
    assert split.groups["skin"].tolist() == list(range(len(split.triangles)))

    def open_edges(triangles: NDArray[np.int32]) -> int:
        counts = np.unique(np.sort(triangle_edges(triangles), axis=1), axis=0, return_counts=True)[1]
        assert counts.max() <= 2
        return int((counts == 1).sum())

    whole = np.unique(np.sort(triangle_edges(mesh.triangles), axis=1), axis=0, return_counts=True)
    border = {tuple(edge) for edge in whole[0][whole[1] == 1].tolist()}
    assert open_edges(split.triangles) == len(border) + sum(tuple(edge) in border for edge in edges.tolist())


def test_no_edges_and_no_triangles_change_nothing(face: SheetFace) -> None:
    assert split_edges(face.mesh, np.empty((0, 2), np.int64), np.empty(0)) is face.mesh
    assert drop_triangles(face.mesh, np.zeros(len(face.mesh.triangles), np.bool_)) is face.mesh


@pytest.mark.slow
def test_dropped_triangles_leave_their_vertices(face: SheetFace) -> None:
    dropped = np.arange(len(face.mesh.triangles)) % 3 == 0
    rest = drop_triangles(face.mesh, dropped)
    assert rest.vertices is face.mesh.vertices
    assert rest.triangles.tolist() == face.mesh.triangles[~dropped].tolist()
    assert rest.groups["skin"].tolist() == list(range((~dropped).sum()))
