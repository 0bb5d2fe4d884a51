"""A cavity closes the hole between the lips of a head without an inside of its mouth."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.default_head import default_points
from conf.face.fitting.mouth_cavity import add_mouth_cavity
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import triangle_edges
from tests.support.modified_heads import EYEBALLS, MOUTH, head_without
from tests.support.sheet_face import SheetFace


def open_edges(mesh: Mesh) -> int:
    counts = np.unique(np.sort(triangle_edges(mesh.triangles), axis=1), axis=0, return_counts=True)[1]
    return int((counts == 1).sum())


@pytest.mark.slow
@pytest.mark.parametrize("inside_out", [False, True])
def test_the_cavity_joins_the_rim_with_the_same_winding(inside_out: bool) -> None:
    mesh = head_without(*MOUTH, *EYEBALLS)
    if inside_out:
        mesh = replace(mesh, triangles=mesh.triangles[:, ::-1], render_triangles=mesh.render_triangles[:, ::-1])
    filled = add_mouth_cavity(mesh, default_points())
    assert filled.vertices[: len(mesh.vertices)].tolist() == mesh.vertices.tolist()
    assert filled.groups["mouth"].tolist() == list(range(len(mesh.triangles), len(filled.triangles)))
    edges = triangle_edges(filled.triangles)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 1  # neighbours run along an edge in two directions
    assert filled.render_vertices[filled.render_triangles].tolist() == filled.triangles.tolist()
    assert len(filled.uvs) == len(filled.render_vertices)
    added = filled.vertices[len(mesh.vertices) :] - default_points()[[1, 2]].mean(axis=0)
    assert added[:, 2].max() < 0.3 and -6 < added[:, 2].min() < -4
    assert np.abs(added[:, 1]).max() < 2


@pytest.mark.slow
def test_a_mouth_with_an_inside_or_without_a_hole_is_left_unchanged(shut_face: SheetFace) -> None:
    head = head_without()
    assert add_mouth_cavity(head, default_points()) is head
    assert add_mouth_cavity(shut_face.mesh, shut_face.points) is shut_face.mesh


@pytest.mark.slow
def test_the_slit_of_a_sheet_gets_a_cavity(face: SheetFace) -> None:
    filled = add_mouth_cavity(face.mesh, face.points)
    assert "mouth" in filled.groups
    assert open_edges(filled) < open_edges(face.mesh) + 60
