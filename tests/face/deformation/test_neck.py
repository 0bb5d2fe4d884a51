from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.deformation.neck import BOTTOM, NECK_RADIUS, PIVOT, SHOULDER_WEIGHT, TOP, NeckBend, head_weights
from conf.face.head_pose import HeadPose
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
    ("beside", "height", "weight"),
    [
        (0.0, TOP + 1, 1.0),
        (0.0, TOP, 1.0),
        (0.0, (TOP + BOTTOM) / 2, 0.5),
        (0.0, BOTTOM, 0.0),
        (0.0, BOTTOM - 1, 0.0),
        (NECK_RADIUS, (TOP + BOTTOM) / 2, 0.5),
        (NECK_RADIUS + 2, (3 * TOP + BOTTOM) / 4, 0.5),  # 2 cm outside the neck all happens at half the depth
        (NECK_RADIUS + 2, (TOP + BOTTOM) / 2, 0.0),
        (NECK_RADIUS + 4, (5 * TOP + BOTTOM) / 6, 0.5),
    ],
)
@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1), (0.6, 0.8)])
def test_weights_fall_from_the_top_to_the_bottom_of_the_neck_and_faster_beside_it(
    beside: float, height: float, weight: float, direction: tuple[float, float]
) -> None:
    x, z = direction
    vertex = np.array([[PIVOT[0] + beside * x, height, PIVOT[2] + beside * z]])
    assert head_weights(vertex) == pytest.approx([weight], abs=1e-5)


def test_every_vertex_is_turned_back_by_its_weight(torso: Mesh) -> None:
    vertices = torso.vertices.astype(np.float32)
    rotation = np.array([0.3, -0.5, 0.4])
    bent = NeckBend(torso).apply(vertices, HeadPose(rotation, np.zeros(2), -3.0))
    assert bent.dtype == np.float32
    weights = head_weights(torso.vertices)
    between = np.flatnonzero((weights > 0.05) & (weights < 0.95))[::5]
    assert len(between) > 10
    for vertex in between:
        back = HeadPose(-rotation * (1 - SHOULDER_WEIGHT) * (1 - weights[vertex]), np.zeros(2), -3.0).matrix()
        assert bent[vertex] == pytest.approx(PIVOT + back @ (vertices[vertex] - PIVOT), abs=1e-4)


def test_the_head_is_not_bent(torso: Mesh) -> None:
    vertices = torso.vertices.astype(np.float32)
    bent = NeckBend(torso).apply(vertices, pose((0.3, -0.5, 0.4)))
    head = vertices[:, 1] >= TOP
    np.testing.assert_array_equal(bent[head], vertices[head])
    assert np.abs(bent - vertices)[~head].max() > 2.0


@given(rotations)
def test_shoulders_follow_a_part_of_the_rotation(torso: Mesh, rotation: tuple[float, float, float]) -> None:
    vertices = torso.vertices.astype(np.float32)
    shoulders = vertices[:, 1] <= BOTTOM
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


def test_a_face_without_shoulders_is_returned_unchanged(face: SheetFace) -> None:
    vertices = face.mesh.vertices.astype(np.float32)
    assert NeckBend(face.mesh).apply(vertices, pose((0.3, 0.3, 0.3))) is vertices


def _lengths(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(np.linalg.norm(rows, axis=1))
