"""Parts of meshes, and meshes put together better than their files have them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh


def weld_vertices(mesh: Mesh, /) -> Mesh:
    """Join vertices at one place where the file repeats every one of them (STL), so that light runs smooth."""
    if len(mesh.vertices) < 3 * len(mesh.triangles):
        return mesh
    places, inverse = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = inverse.ravel()[mesh.triangles].astype(np.int32)
    ones = np.arange(len(places), dtype=np.int32)
    return replace(
        mesh, vertices=places, triangles=triangles, render_triangles=triangles, render_vertices=ones,
        uvs=np.zeros((len(places), 2)), texture=None,
    )  # fmt: skip


def submesh(mesh: Mesh, kept: NDArray[np.bool_], /) -> Mesh:
    """Return the triangles that are kept, (F,), and the vertices they use."""
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
    """Return the mesh with some triangles, (k,) by their new group, taken out of all other groups."""
    if not parts:
        return mesh
    taken = np.concatenate(list(parts.values()))
    groups = {name: members[~np.isin(members, taken)] for name, members in mesh.groups.items()}
    for name, members in parts.items():
        groups[name] = np.union1d(groups.get(name, members), members)
    return replace(mesh, groups={name: members for name, members in groups.items() if len(members)})
