from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.deformation.neck import BOTTOM, PIVOT, SHOULDER_WEIGHT, SLOPE, TOP, NeckBend, head_weights
from conf.face.head_pose import HeadPose
from conf.face.loading import load_face
from conf.face.mesh.mesh import Mesh
from tests.support.sheet_face import SheetFace

angle = st.floats(-0.7, 0.7)
rotations = st.tuples(angle, angle, angle)


def pose(rotation: tuple[float, float, float]) -> HeadPose:
    return HeadPose(np.array(rotation), np.zeros(2), -3.0)


@pytest.fixture(scope="module")
def torso(face: SheetFace) -> Mesh:
    """Return the sheet stretched down to the chest, with a torso group."""
    vertices = face.mesh.vertices * [1.0, 2.5, 1.0]
    return replace(face.mesh, vertices=vertices, groups={**face.mesh.groups, "shirt": np.arange(3)})


@pytest.mark.parametrize(
    ("above_bottom", "weight"),
    [(7.0, 1.0), (6.0, 1.0), (4.5, 27 / 32), (3.0, 0.5), (1.5, 5 / 32), (0.0, 0.0), (-1.0, 0.0)],
)
@pytest.mark.parametrize(("x", "z"), [(0.0, 0.0), (6.0, 0.0), (0.0, -13.0), (-4.0, 3.0)])
def test_weights_fall_between_two_planes_that_fall_towards_the_front(
    above_bottom: float, weight: float, x: float, z: float
) -> None:
    assert TOP - BOTTOM == pytest.approx(6.0)
    vertex = np.array([[x, BOTTOM + above_bottom + SLOPE * z, z]])
    assert head_weights(vertex) == pytest.approx([weight], abs=1e-5)


def test_every_vertex_is_turned_back_by_its_weight(torso: Mesh) -> None:
    vertices = torso.vertices.astype(np.float32)
    rotation = np.array([0.3, -0.5, 0.4])
    bent = NeckBend(torso).apply(vertices, HeadPose(rotation, np.zeros(2), -3.0))
    assert bent.dtype == np.float32
    weights = head_weights(torso.vertices)
    weights[:3] = 0.0  # the group of the torso
    between = np.flatnonzero((weights > 0.05) & (weights < 0.95))[::5]
    assert len(between) > 10
    for vertex in between:
        back = HeadPose(-rotation * (1 - SHOULDER_WEIGHT) * (1 - weights[vertex]), np.zeros(2), -3.0).matrix()
        assert bent[vertex] == pytest.approx(PIVOT + back @ (vertices[vertex] - PIVOT), abs=1e-4)


def test_the_head_is_not_bent(torso: Mesh) -> None:
    vertices = torso.vertices.astype(np.float32)
    bent = NeckBend(torso).apply(vertices, pose((0.3, -0.5, 0.4)))
    head = level(vertices) >= TOP
    head[:3] = False  # the group of the torso
    np.testing.assert_array_equal(bent[head], vertices[head])
    assert np.abs(bent - vertices)[~head].max() > 2.0


@pytest.mark.slow
@given(rotations)
def test_shoulders_follow_a_part_of_the_rotation(torso: Mesh, rotation: tuple[float, float, float]) -> None:
    vertices = torso.vertices.astype(np.float32)
    shoulders = level(vertices) <= BOTTOM
    shoulders[:3] = True
    bent = NeckBend(torso).apply(vertices, pose(rotation))[shoulders]
    posed = (bent - PIVOT) @ pose(rotation).matrix().T
    reduced = pose(tuple(SHOULDER_WEIGHT * t for t in rotation)).matrix()  # type: ignore[arg-type]
    np.testing.assert_allclose(posed, (vertices[shoulders] - PIVOT) @ reduced.T, atol=1e-4)


@pytest.mark.slow
@given(rotations)
def test_bending_is_smooth_and_keeps_distances(torso: Mesh, rotation: tuple[float, float, float]) -> None:
    """Every vertex keeps its distance from the pivot, and weights change little between neighbours."""
    vertices = torso.vertices.astype(np.float32)
    bent = NeckBend(torso).apply(vertices, pose(rotation))
    np.testing.assert_allclose(_lengths(bent - PIVOT), _lengths(vertices - PIVOT), atol=1e-4)
    line = np.stack([np.full(200, 5.0), np.linspace(-8, -21, 200), np.full(200, -4.0)], axis=1)
    assert np.abs(np.diff(head_weights(line))).max() < 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    "rotation",
    [
        *[(0.6, 0.0, 0.0), (-0.6, 0.0, 0.0), (0.0, 0.9, 0.0), (0.0, -0.9, 0.0), (0.0, 0.0, 0.5), (0.0, 0.0, -0.5)],
        *[(0.5, 0.0, 0.5), (-0.5, 0.0, 0.5), (-0.5, 0.8, 0.0), (0.5, -0.8, 0.0), (0.0, 0.8, -0.5), (-0.4, 0.6, 0.4)],
    ],
)
def test_the_skin_of_the_default_head_stays_inside_its_collar(rotation: tuple[float, float, float]) -> None:
    """Skin near the shirt keeps its distance from it, however the head is turned."""
    mesh = load_face().mesh
    skin, shirt = mesh.group_vertices("skin"), mesh.group_vertices("shirt")
    found = cKDTree(mesh.vertices[shirt]).query(mesh.vertices[skin])
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    near = distance < 1.0
    bent = NeckBend(mesh).apply(mesh.vertices.astype(np.float32), pose(rotation))
    assert near.sum() > 100
    moved = _lengths(bent[skin[near]] - bent[shirt[nearest[near]]])
    np.testing.assert_allclose(moved, distance[near], atol=0.05)


def test_a_face_without_shoulders_is_returned_unchanged(face: SheetFace) -> None:
    vertices = face.mesh.vertices.astype(np.float32)
    assert NeckBend(face.mesh).apply(vertices, pose((0.3, 0.3, 0.3))) is vertices


def level(vertices: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(vertices[:, 1] - SLOPE * vertices[:, 2])


def _lengths(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(np.linalg.norm(rows, axis=1))
