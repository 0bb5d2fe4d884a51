"""Weld, cut out and regroup the parts of a mesh."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh


def weld_vertices(mesh: Mesh, /) -> Mesh:
    """Join coinciding vertices where the file repeats every one of them (STL), so that shading is smooth."""
    if len(mesh.vertices) < 3 * len(mesh.triangles):
        return mesh
    positions, inverse = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = inverse.ravel()[mesh.triangles].astype(np.int32)
    identity = np.arange(len(positions), dtype=np.int32)
    return replace(
        mesh, vertices=positions, triangles=triangles, render_triangles=triangles, render_vertices=identity,
        uvs=np.zeros((len(positions), 2)), texture=None,
    )  # fmt: skip


def submesh(mesh: Mesh, kept: NDArray[np.bool_], /) -> Mesh:
    """Return the mesh of the kept triangles, (F,), and the vertices they use."""
    used, triangles = np.unique(mesh.triangles[kept], return_inverse=True)
    used_rows, rows = np.unique(mesh.render_triangles[kept], return_inverse=True)
    numbers = np.cumsum(kept) - 1
    groups = {name: numbers[members[kept[members]]] for name, members in mesh.groups.items()}
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        triangles=triangles.reshape(-1, 3).astype(np.int32),
        uvs=mesh.uvs[used_rows],
        render_vertices=np.searchsorted(used, mesh.render_vertices[used_rows]).astype(np.int32),
        render_triangles=rows.reshape(-1, 3).astype(np.int32),
        groups={name: members for name, members in groups.items() if len(members)},
    )


def regroup(mesh: Mesh, parts: Mapping[str, NDArray[np.int64]], /) -> Mesh:
    """Return the mesh with some triangles moved to other groups. parts : new group -> (k,) its triangles."""
    if not parts:
        return mesh
    moved = np.concatenate(list(parts.values()))
    groups = {name: members[~np.isin(members, moved)] for name, members in mesh.groups.items()}
    for name, members in parts.items():
        groups[name] = np.union1d(groups.get(name, members), members)
    return replace(mesh, groups={name: members for name, members in groups.items() if len(members)})


def grid_triangles(grid: NDArray[np.int64], /) -> NDArray[np.int64]:
    """Return the (2 (r - 1) (c - 1), 3) triangles that cover a grid (r, c) of vertex indices."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
