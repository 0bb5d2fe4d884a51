import numpy as np
import pytest

from conf.face.fitting.lip_rim import sharpen_lip_rim
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.winding import triangle_normals
from conf.render.vertex_normals import VertexNormals
from tests.support.sheet_face import SheetFace


@pytest.fixture
def lip() -> Mesh:
    """Return a lower lip: a sheet that faces the viewer, and at its upper edge one that leads 1 cm into the mouth."""
    x = np.arange(5.0)
    rows = [np.stack([x, np.full(5, y), np.full(5, z)], 1) for y, z in ((-1.0, 0.0), (0.0, 0.0), (-0.5, -1.0))]
    corner = (np.arange(2)[:, None] * 5 + np.arange(4)).ravel()
    quads = np.stack([corner, corner + 1, corner + 6, corner + 5], axis=1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    corners = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    inside = np.flatnonzero((triangles >= 10).any(axis=1))
    return build_mesh(RawMesh(np.concatenate(rows), np.empty((0, 2)), corners, {"mouth": inside}, None))


def test_the_normals_of_the_rim_are_those_of_the_outside(lip: Mesh) -> None:
    sharp, facing = sharpen_lip_rim(lip), []
    for mesh in (lip, sharp):
        normals = VertexNormals(mesh.triangles, mesh.render_vertices).normals(mesh.vertices.astype(np.float32))
        rim = normals[6:9] / np.linalg.norm(normals[6:9], axis=1, keepdims=True)
        facing.append(float(rim[:, 2].min()))
    assert facing[0] < 0.5 < 0.95 < facing[1]
    np.testing.assert_array_equal(sharp.vertices[: len(lip.vertices)], lip.vertices)
    added = sharp.vertices[len(lip.vertices) :]
    assert np.abs(added[:, 1:]).max() < 0.031
    areas = [np.linalg.norm(triangle_normals(m.vertices, m.triangles), axis=1) for m in (lip, sharp)]
    assert areas[0].sum() == pytest.approx(areas[1].sum())
    assert len(sharp.groups["mouth"]) > len(lip.groups["mouth"])


def test_a_face_without_an_inside_of_the_mouth_stays_as_it_is(face: SheetFace) -> None:
    assert sharpen_lip_rim(face.mesh) is face.mesh
