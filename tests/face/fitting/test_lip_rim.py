import numpy as np
import pytest

from conf.face.control_points import LOWER_LIP_EDGE, UPPER_LIP_EDGE
from conf.face.fitting.lip_rim import sharpen_lip_rim
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.winding import triangle_normals
from conf.render.vertex_normals import VertexNormals
from tests.support.sheet_face import SheetFace


def lower_lip(*, first_row: int) -> Mesh:
    """Return a sheet that faces the viewer, and at its upper edge one that leads 2 cm back and down.

    first_row : of vertices that only triangles of the group "mouth" use
    """
    x = np.arange(5.0)
    heights_and_depths = ((-1.0, 0.0), (0.0, 0.0), (-0.5, -1.0), (-1.0, -2.0))
    rows = [np.stack([x, np.full(5, y), np.full(5, z)], 1) for y, z in heights_and_depths]
    corner = (np.arange(3)[:, None] * 5 + np.arange(4)).ravel()
    quads = np.stack([corner, corner + 1, corner + 6, corner + 5], axis=1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    corners = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    inside = np.flatnonzero((triangles >= 5 * first_row).any(axis=1))
    return build_mesh(RawMesh(np.concatenate(rows), np.empty((0, 2)), corners, {"mouth": inside}, None))


@pytest.mark.parametrize("first_row", [2, 3])
def test_the_normals_of_the_rim_are_those_of_the_outside(first_row: int) -> None:
    """Also if the first row into the mouth is lip, and the mouth begins behind it."""
    lip, points, facing = lower_lip(first_row=first_row), np.full((50, 3), 100.0), []
    for edge in (UPPER_LIP_EDGE, LOWER_LIP_EDGE):
        points[edge] = np.stack([np.arange(5.0), np.zeros(5), np.zeros(5)], 1)
    sharp = sharpen_lip_rim(lip, points)
    for mesh in (lip, sharp):
        normals = VertexNormals(mesh.triangles, mesh.render_vertices).normals(mesh.vertices.astype(np.float32))
        rim = normals[6:9] / np.linalg.norm(normals[6:9], axis=1, keepdims=True)
        facing.append(float(rim[:, 2].min()))
    assert facing[0] < 0.5 < 0.95 < facing[1]
    np.testing.assert_array_equal(sharp.vertices[: len(lip.vertices)], lip.vertices)
    added = sharp.vertices[len(lip.vertices) :]
    assert len(added) and np.abs(added[:, 1:]).max() < 0.031
    groups = {"mouth", "inner_lips"} if first_row == 3 else {"mouth"}
    assert set(sharp.groups) == groups
    areas = [np.linalg.norm(triangle_normals(m.vertices, m.triangles), axis=1) for m in (lip, sharp)]
    assert areas[0].sum() == pytest.approx(areas[1].sum())


def test_a_face_without_an_inside_of_the_mouth_stays_as_it_is(face: SheetFace) -> None:
    assert sharpen_lip_rim(face.mesh, face.points) is face.mesh
