"""Vertices are welded, parts cut out and triangles regrouped."""

from dataclasses import replace

import numpy as np

from conf.face.formats.obj import RawMesh
from conf.face.mesh.editing import regroup, submesh, weld_vertices
from conf.face.mesh.mesh import build_mesh

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]])


def test_repeated_vertices_are_welded() -> None:
    corners = np.stack([np.arange(6).reshape(2, 3), np.full((2, 3), -1)], axis=2)
    loose = build_mesh(RawMesh(SQUARE, np.empty((0, 2)), corners, {"skin": np.arange(2)}, None))
    joined = weld_vertices(loose)
    assert len(joined.vertices) == 4
    np.testing.assert_array_equal(joined.vertices[joined.triangles], loose.vertices[loose.triangles])
    shared = replace(joined, groups={})
    assert weld_vertices(shared) is shared


def test_a_submesh_keeps_positions_groups_and_texture_coordinates() -> None:
    uvs = np.arange(12.0).reshape(6, 2)
    corners = np.repeat(np.arange(6).reshape(2, 3, 1), 2, axis=2)
    whole = build_mesh(RawMesh(SQUARE, uvs, corners, {"a": np.array([0]), "b": np.array([1])}, None))
    part = submesh(whole, np.array([False, True]))
    np.testing.assert_array_equal(part.vertices[part.triangles], SQUARE[None, 3:])
    np.testing.assert_array_equal(part.uvs[part.render_triangles], uvs[None, 3:])
    np.testing.assert_array_equal(part.render_vertices[part.render_triangles], part.triangles)
    assert {name: members.tolist() for name, members in part.groups.items()} == {"b": [0]}


def test_regrouped_triangles_leave_their_old_groups() -> None:
    corners = np.stack([np.arange(6).reshape(2, 3), np.full((2, 3), -1)], axis=2)
    groups = {"all": np.arange(2), "tongue": np.array([1]), "second": np.array([1])}
    mesh = build_mesh(RawMesh(SQUARE, np.empty((0, 2)), corners, groups, None))
    named = regroup(mesh, {"tongue": np.array([0])})
    assert {name: members.tolist() for name, members in named.groups.items()} == {
        "all": [1],
        "tongue": [0, 1],
        "second": [1],
    }
    assert regroup(mesh, {}) is mesh
