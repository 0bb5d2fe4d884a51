import numpy as np
import pytest

from conf.face.loading import load_face
from conf.face.mesh.mesh import Mesh
from conf.render.preparation.vertex_cache import optimise_vertex_cache

CACHE_SIZE = 32  # vertices, far fewer than a head has


def count_transforms(triangles: np.ndarray) -> int:
    """Return how many vertices are transformed if the last CACHE_SIZE are cached."""
    cached, count = list[int](), 0
    for corner in triangles.ravel().tolist():
        if corner not in cached:
            count += 1
            cached = [*cached[1 - CACHE_SIZE :], corner]
    return count


def shuffled(mesh: Mesh) -> Mesh:
    order = np.random.default_rng(1).permutation(len(mesh.triangles))
    new_index = np.argsort(order)
    groups = {name: np.sort(new_index[members]) for name, members in mesh.groups.items()}
    return Mesh(
        mesh.vertices, mesh.triangles[order], mesh.uvs, mesh.render_vertices, mesh.render_triangles[order], groups
    )


def corners_of(mesh: Mesh, triangles: np.ndarray) -> list[bytes]:
    """Return the positions and texture coordinates of the corners of each triangle."""
    rows = mesh.render_triangles[triangles]
    faces = np.concatenate([mesh.vertices[mesh.render_vertices[rows]], mesh.uvs[rows]], axis=2)
    return [face.tobytes() for face in faces]


@pytest.mark.slow
def test_the_mesh_is_the_same_and_each_vertex_is_transformed_about_once() -> None:
    mesh = shuffled(load_face().mesh)
    ordered = optimise_vertex_cache(mesh)
    assert np.array_equal(ordered.render_vertices[ordered.render_triangles], ordered.triangles)
    for name, members in mesh.groups.items():
        assert sorted(corners_of(ordered, ordered.groups[name])) == sorted(corners_of(mesh, members))
    hair = corners_of(ordered, ordered.groups["hair"])
    assert hair == corners_of(mesh, mesh.groups["hair"]), "blended triangles keep their order"
    assert np.array_equal(ordered.vertices, mesh.vertices)
    skin, before = (m.render_triangles[m.groups["skin"]] for m in (ordered, mesh))
    assert count_transforms(before) > 2 * len(np.unique(skin)) > count_transforms(skin)


def test_unused_render_vertices_are_kept() -> None:
    triangles = np.array([[3, 1, 4]], np.int32)
    five = np.arange(5, dtype=np.int32)
    ordered = optimise_vertex_cache(Mesh(np.eye(5, 3), triangles, np.zeros((0, 2)), five, triangles, {}))
    assert sorted(ordered.render_vertices.tolist()) == [0, 1, 2, 3, 4]
    assert ordered.render_vertices[ordered.render_triangles].tolist() == [[3, 1, 4]]
