import numpy as np

from conf.face.loading import load_face
from conf.face.mesh.mesh import Mesh
from conf.render.vertex_cache import optimise_vertex_cache

MEMORY = 32  # vertices that a card holds: far less than a head has


def computed(triangles: np.ndarray) -> int:
    """Return how many vertices are computed if the last MEMORY are held."""
    held, count = list[int](), 0
    for corner in triangles.ravel().tolist():
        if corner not in held:
            count += 1
            held = [*held[1 - MEMORY :], corner]
    return count


def shuffled(mesh: Mesh) -> Mesh:
    order = np.random.default_rng(1).permutation(len(mesh.triangles))
    places = np.argsort(order)
    groups = {name: np.sort(places[members]) for name, members in mesh.groups.items()}
    return Mesh(
        mesh.vertices, mesh.triangles[order], mesh.uvs, mesh.render_vertices, mesh.render_triangles[order], groups
    )


def corners_of(mesh: Mesh, triangles: np.ndarray) -> list[bytes]:
    """Return what each triangle looks like: places and texture coordinates of its corners."""
    rows = mesh.render_triangles[triangles]
    faces = np.concatenate([mesh.vertices[mesh.render_vertices[rows]], mesh.uvs[rows]], axis=2)
    return [face.tobytes() for face in faces]


def test_the_mesh_is_the_same_and_its_vertices_are_computed_about_once() -> None:
    mesh = shuffled(load_face().mesh)
    ordered = optimise_vertex_cache(mesh)
    assert np.array_equal(ordered.render_vertices[ordered.render_triangles], ordered.triangles)
    for name, members in mesh.groups.items():
        assert sorted(corners_of(ordered, ordered.groups[name])) == sorted(corners_of(mesh, members))
    hair = corners_of(ordered, ordered.groups["hair"])
    assert hair == corners_of(mesh, mesh.groups["hair"]), "what is blended must be drawn in its order"
    assert np.array_equal(ordered.vertices, mesh.vertices)
    skin, before = (m.render_triangles[m.groups["skin"]] for m in (ordered, mesh))
    assert computed(before) > 2 * len(np.unique(skin)) > computed(skin)


def test_rows_that_no_triangle_uses_stay() -> None:
    triangles = np.array([[3, 1, 4]], np.int32)
    five = np.arange(5, dtype=np.int32)
    ordered = optimise_vertex_cache(Mesh(np.eye(5, 3), triangles, np.zeros((0, 2)), five, triangles, {}))
    assert sorted(ordered.render_vertices.tolist()) == [0, 1, 2, 3, 4]
    assert ordered.render_vertices[ordered.render_triangles].tolist() == [[3, 1, 4]]
