"""The initial alignment: scale and position of a face in a mesh, or none if it is not upright."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.face.fitting.face_prior import load_prior
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.mesh_fitting.face_search import initial_alignment


@pytest.fixture
def wall() -> Mesh:
    """A flat wall at z = 4."""
    plane = trimesh.creation.box(extents=(400.0, 400.0, 8.0))
    faces = np.asarray(plane.faces)
    corners = np.stack([faces, np.full_like(faces, -1)], axis=2)
    return build_mesh(RawMesh(np.asarray(plane.vertices), np.empty((0, 2)), corners, {}, None))


def rotated(positions: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
    angle = np.radians(degrees)
    return positions @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_scale_and_position_are_found(wall: Mesh, scale: float) -> None:
    prior = load_prior()
    frame = initial_alignment(prior.mean[:, :2] * scale + [3.0, -2.0], wall, prior)
    assert frame is not None
    assert frame.scale == pytest.approx(1 / scale)
    found = frame.apply(np.array([*(prior.mean[0, :2] * scale + [3.0, -2.0]), 4.0]))
    np.testing.assert_allclose(found[:2], prior.mean[0, :2], atol=1e-9)
    assert found[2] == pytest.approx(np.median(prior.mean[:, 2]))


@pytest.mark.parametrize("degrees", [-90.0, 60.0, 180.0])
def test_a_face_that_is_not_upright_is_rejected(wall: Mesh, degrees: float) -> None:
    prior = load_prior()
    assert initial_alignment(rotated(prior.mean[:, :2], degrees), wall, prior) is None
    assert initial_alignment(rotated(prior.mean[:, :2], 15.0), wall, prior) is not None


def test_a_face_beside_the_mesh_is_rejected(wall: Mesh) -> None:
    prior = load_prior()
    assert initial_alignment(prior.mean[:, :2] + 900.0, wall, prior) is None
