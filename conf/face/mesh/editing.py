"""Weld, cut out and regroup the parts of a mesh."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh


def weld_vertices(mesh: Mesh, /) -> Mesh:
    """Join coinciding vertices where the file repeats every one of them (STL), so that shading is smooth."""
    if len(mesh.vertices) < 3 * len(mesh.triangles):
        return mesh
    positions, first, inverse = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    triangles = inverse.ravel()[mesh.triangles].astype(np.int32)
    colours = None if mesh.vertex_colours is None else mesh.vertex_colours[first]
    if mesh.texture is not None or any(material.image is not None for material in mesh.materials):
        rows = inverse.ravel()[mesh.render_vertices].astype(np.int32)
        return replace(mesh, vertices=positions, triangles=triangles, render_vertices=rows, vertex_colours=colours)
    identity = np.arange(len(positions), dtype=np.int32)
    return replace(
        mesh, vertices=positions, triangles=triangles, render_triangles=triangles, render_vertices=identity,
        uvs=np.zeros((len(positions), 2)), vertex_colours=colours,
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
        triangle_materials=None if mesh.triangle_materials is None else mesh.triangle_materials[kept],
        vertex_colours=None if mesh.vertex_colours is None else mesh.vertex_colours[used],
    )


def with_colours_of(
    raw: RawMesh,
    mesh: Mesh,
    /,
    *,
    origin: NDArray[np.integer] | None = None,
    new_colours: NDArray[np.floating] | None = None,
) -> RawMesh:
    """Return an edited mesh with the materials, vertex colours and notes of the mesh that it was made of.

    origin : (k,) the triangle of the mesh that each of the first k triangles was part of, None for the same; those
        after them have no material
    new_colours : (n, 3) colours of the first vertices after those of the mesh; the colour of all others is white
    """
    materials, colours = mesh.triangle_materials, mesh.vertex_colours
    if materials is not None:
        materials = materials if origin is None else materials[origin]
        materials = np.append(materials, np.full(len(raw.corners) - len(materials), -1, np.int32))
    if colours is not None:
        colours = colours if new_colours is None else np.concatenate([colours, new_colours.astype(np.float32)])
        colours = np.concatenate([colours, np.ones((len(raw.positions) - len(colours), 3), np.float32)])
    return replace(
        raw, materials=mesh.materials, triangle_materials=materials, vertex_colours=colours, notes=mesh.notes
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
