"""Split edges of a mesh; the triangles beside them are divided so that no gaps arise."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh

# Which edges of a triangle are split (1 first, 2 second, 4 third) -> its parts. Corners 0 to 2 are its own; 3, 4 and 5
# are the new vertices on its first edge, from corner 0 to 1, on its second and on its third.
_PARTS = {
    1: ((0, 3, 2), (3, 1, 2)),
    2: ((0, 1, 4), (0, 4, 2)),
    3: ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    4: ((0, 1, 5), (5, 1, 2)),
    5: ((0, 3, 5), (3, 1, 2), (3, 2, 5)),
    6: ((4, 2, 5), (0, 1, 4), (0, 4, 5)),
    7: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}


def split_edges(mesh: Mesh, edges: NDArray[np.integer], fractions: NDArray[np.float64], /) -> Mesh:
    """Return the mesh with a new vertex on each of some edges; new vertices come after those of the mesh.

    edges : (k, 2) vertices, the smaller index first, no edge twice
    fractions : (k,) position of the new vertex from the first vertex (0) to the second (1)
    """
    count, render_count = len(mesh.vertices), len(mesh.render_vertices)
    if not len(edges):
        return mesh
    keys = edges[:, 0].astype(np.int64) * count + edges[:, 1]
    order = np.argsort(keys)
    starts = mesh.triangles.astype(np.int64)
    ends = np.roll(starts, -1, axis=1)
    wanted = np.minimum(starts, ends) * count + np.maximum(starts, ends)
    at = order[np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)]
    split = keys[at] == wanted  # (F, 3)
    first, second = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]]

    render_starts = mesh.render_triangles.astype(np.int64)
    render_ends = np.roll(render_starts, -1, axis=1)
    forwards = (starts < ends)[split]
    pairs = np.stack(
        [
            np.where(forwards, render_starts[split], render_ends[split]),
            np.where(forwards, render_ends[split], render_starts[split]),
            at[split],
        ],
        axis=1,
    )
    pairs, inverse = np.unique(pairs, axis=0, return_inverse=True)
    new_render = np.full(split.shape, -1, dtype=np.int64)
    new_render[split] = render_count + inverse.ravel()
    t = fractions[pairs[:, 2], None]

    corners = np.concatenate([starts, count + at], axis=1)
    render_corners = np.concatenate([render_starts, new_render], axis=1)
    kind = split @ np.array([1, 2, 4])
    rows = [np.flatnonzero(kind == 0)]
    parts, render_parts, origin = [starts[rows[0]]], [render_starts[rows[0]]], [rows[0]]
    for number, pattern in _PARTS.items():
        own = np.flatnonzero(kind == number)
        parts.append(corners[own][:, pattern].reshape(-1, 3))
        render_parts.append(render_corners[own][:, pattern].reshape(-1, 3))
        origin.append(own.repeat(len(pattern)))
    origins = np.concatenate(origin)
    materials, colours = mesh.triangle_materials, mesh.vertex_colours
    if colours is not None:
        ends_of_edges = colours.astype(np.float64)[edges]  # (k, 2, 3)
        added = ends_of_edges[:, 0] + fractions[:, None] * (ends_of_edges[:, 1] - ends_of_edges[:, 0])
        colours = np.concatenate([colours, added.astype(np.float32)])
    return replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, first + fractions[:, None] * (second - first)]),
        triangles=np.concatenate(parts).astype(np.int32),
        uvs=np.concatenate([mesh.uvs, mesh.uvs[pairs[:, 0]] * (1 - t) + mesh.uvs[pairs[:, 1]] * t]),
        render_vertices=np.concatenate([mesh.render_vertices, count + pairs[:, 2]]).astype(np.int32),
        render_triangles=np.concatenate(render_parts).astype(np.int32),
        groups={name: np.flatnonzero(np.isin(origins, members)) for name, members in mesh.groups.items()},
        triangle_materials=None if materials is None else materials[origins],
        vertex_colours=colours,
    )


def drop_triangles(mesh: Mesh, dropped: NDArray[np.bool_], /) -> Mesh:
    """Return the mesh without some triangles, (F,); all vertices stay, so that their numbers do."""
    if not dropped.any():
        return mesh
    numbers = np.cumsum(~dropped) - 1
    groups = {name: numbers[members[~dropped[members]]] for name, members in mesh.groups.items()}
    return replace(
        mesh,
        triangles=mesh.triangles[~dropped],
        render_triangles=mesh.render_triangles[~dropped],
        groups={name: members for name, members in groups.items() if len(members)},
        triangle_materials=None if mesh.triangle_materials is None else mesh.triangle_materials[~dropped],
    )
