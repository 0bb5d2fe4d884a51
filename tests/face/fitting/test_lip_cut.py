"""A sheet whose lips are one surface is cut open without tears, with a closed cavity behind."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP
from conf.face.fitting.lip_cut import cut_lips, has_open_lips
from conf.face.loading import build_face
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.mesh.winding import triangle_normals
from tests.support.sheet_face import SheetFace

INNER = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]


def surface_of(mesh: Mesh) -> SurfaceGraph:
    return SurfaceGraph(mesh.vertices, mesh.triangles)


@pytest.fixture(scope="module")
def touching(shut_face: SheetFace) -> SheetFace:
    """The sheet with its inner lip points together, as on a face at rest."""
    points = shut_face.points.copy()
    for side in ("mid", "l", "r"):
        pair = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_{side}"] for lip in ("upper", "lower")]
        points[pair] = points[pair].mean(axis=0) + np.array([[0, 0.05, 0], [0, -0.05, 0]])
    return replace(shut_face, points=points)


@pytest.fixture(scope="module")
def opened(touching: SheetFace) -> Mesh:
    return cut_lips(touching.mesh, touching.points, surface_of(touching.mesh))


def boundary(mesh: Mesh) -> set[tuple[int, int]]:
    """Return the edges that belong to one triangle only."""
    edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    once, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    return {(int(a), int(b)) for a, b in once[count == 1]}


def test_open_and_closed_lips_are_distinguished(face: SheetFace, touching: SheetFace, opened: Mesh) -> None:
    assert has_open_lips(face.points, surface_of(face.mesh))
    assert not has_open_lips(touching.points, surface_of(touching.mesh))
    assert has_open_lips(touching.points, surface_of(opened))


@pytest.mark.slow
def test_original_vertices_come_first_and_the_boundary_is_unchanged(touching: SheetFace, opened: Mesh) -> None:
    count = len(touching.mesh.vertices)
    assert opened.vertices[:count].tolist() == touching.mesh.vertices.tolist()
    assert boundary(opened) == boundary(touching.mesh)  # neither a tear nor a gap between lips and cavity


def test_the_cut_keeps_the_area_and_the_winding(touching: SheetFace, opened: Mesh) -> None:
    skin = np.setdiff1d(np.arange(len(opened.triangles)), opened.groups["mouth"])
    before, after = (
        triangle_normals(touching.mesh.vertices, touching.mesh.triangles),
        triangle_normals(opened.vertices, opened.triangles[skin]),
    )
    assert np.linalg.norm(after, axis=1).sum() == pytest.approx(np.linalg.norm(before, axis=1).sum())
    assert (after[:, 2] > 0).all() == (before[:, 2] > 0).all()
    assert sorted(opened.groups["skin"].tolist()) == skin.tolist()


@pytest.mark.parametrize("inside_out", [False, True])
def test_the_cavity_lies_behind_the_lips_and_faces_inwards(touching: SheetFace, inside_out: bool) -> None:
    mesh = touching.mesh
    if inside_out:
        mesh = replace(mesh, triangles=mesh.triangles[:, ::-1], render_triangles=mesh.render_triangles[:, ::-1])
    opened = cut_lips(mesh, touching.points, surface_of(mesh))
    corners = opened.vertices[opened.triangles[opened.groups["mouth"]]]
    assert corners[..., 2].max() <= touching.points[:, 2].max()
    normals = triangle_normals(opened.vertices, opened.triangles[opened.groups["mouth"]])
    centre = corners.reshape(-1, 3).mean(axis=0)
    inwards = np.einsum("fi,fi->f", normals, centre - corners.mean(axis=1)) * (-1 if inside_out else 1)
    assert inwards.sum() > 0.95 * np.abs(inwards).sum()


@pytest.mark.slow
def test_the_lower_lip_moves_without_the_upper(touching: SheetFace, opened: Mesh) -> None:
    closed_face, open_face = (build_face(mesh, touching.points) for mesh in (touching.mesh, opened))
    displacements = np.zeros((50, 3))
    displacements[LOWER_LIP, 1] = -1.0 / closed_face.fapu.lengths()[INNER[1], 1]
    count = len(touching.mesh.vertices)
    new = opened.vertices[count:]
    on_rim = count + np.flatnonzero((np.abs(new[:, 0]) < 0.3) & (new[:, 2] > touching.points[INNER[0], 2] - 0.05))
    offsets = open_face.deform(displacements)[on_rim, 1] - open_face.neutral[on_rim, 1]
    assert offsets.max() > -0.1  # the upper lip stays
    assert offsets.min() < -0.8  # the lower one moves down
    assert not ((offsets > -0.7) & (offsets < -0.2)).any()  # and no vertex lies between them


def test_a_mesh_with_nothing_to_cut_is_returned_unchanged(face: SheetFace) -> None:
    far = replace(face.mesh, vertices=face.mesh.vertices + np.array([0.0, 100.0, 0.0]))
    assert cut_lips(far, face.points, surface_of(far)) is far
