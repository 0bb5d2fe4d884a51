from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LID, LOWER_LIP, UPPER_LID, UPPER_LIP
from conf.face.deformation.rbf import KERNELS, build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace

NO_ANCHORS = np.empty((0, 3))


def split(face: SheetFace) -> Regions:
    surface = SurfaceGraph(face.mesh.vertices, face.mesh.triangles)
    return split_regions(surface, face.points, anchors=NO_ANCHORS)


def matrix_of(face: SheetFace, regions: Regions | None) -> np.ndarray:
    return build_operator(
        face.mesh.vertices, face.points, kernel=KERNELS["multiquadric"], epsilon=1.0, regions=regions
    ).matrix


def lips(face: SheetFace) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices of the upper and the lower lip, away from the corners."""
    x, y = face.mesh.vertices[:, 0], face.mesh.vertices[:, 1]
    near = (np.abs(x) < 1.3) & np.isin(np.arange(len(x)), face.mesh.triangles)
    return np.flatnonzero(near & (y > -4.15) & (y < -3.2)), np.flatnonzero(near & (y < -4.45) & (y > -5.5))


@pytest.mark.parametrize("mouth", ["face", "shut_face"])
def test_the_weights_of_the_fields_add_up_to_one(mouth: str, request: pytest.FixtureRequest) -> None:
    regions = split(request.getfixturevalue(mouth))
    weights = np.array([field.weights for field in regions.fields])
    assert weights.sum(axis=0) == pytest.approx(1)
    assert weights.min() >= 0


def test_one_lip_does_not_move_the_other(face: SheetFace) -> None:
    matrix, (upper, lower) = matrix_of(face, split(face)), lips(face)
    assert np.abs(matrix[lower][:, UPPER_LIP]).max() < 0.02
    assert np.abs(matrix[upper][:, LOWER_LIP]).max() < 0.02
    unrestricted = matrix_of(face, None)
    assert np.abs(unrestricted[lower][:, UPPER_LIP]).max() > 0.2  # the effect of the regions


def test_each_lip_follows_its_own_points(face: SheetFace) -> None:
    offsets = np.zeros((50, 3), dtype=np.float32)
    offsets[UPPER_LIP, 1], offsets[LOWER_LIP, 1] = 0.5, -1.0
    moved, (upper, lower) = matrix_of(face, split(face)) @ offsets, lips(face)
    assert moved[upper, 1] == pytest.approx(0.5, abs=0.2)
    assert moved[lower, 1] == pytest.approx(-1.0, abs=0.3)


def test_the_dominant_field_of_a_point_does_not_exclude_it(face: SheetFace) -> None:
    regions = split(face)
    nearest = SurfaceGraph(face.mesh.vertices, face.mesh.triangles).nearest_vertices(face.points, tolerance=0.3)
    for group in (UPPER_LIP, LOWER_LIP, UPPER_LID, LOWER_LID):
        for point in group:
            field = max(regions.fields, key=lambda field: field.weights[nearest[point]])
            assert point not in field.excluded


def test_a_face_without_a_mouth_opening_does_not_fold(shut_face: SheetFace) -> None:
    offsets = np.zeros((50, 3), dtype=np.float32)
    offsets[UPPER_LIP, 1], offsets[LOWER_LIP, 1] = 0.2, -0.2
    moved = shut_face.mesh.vertices + matrix_of(shut_face, split(shut_face)) @ offsets
    rows = moved[:, 1].reshape(-1, 81)
    assert np.diff(rows, axis=0).min() > 0  # no row of vertices passes the next


def test_excluded_points_do_not_act(face: SheetFace) -> None:
    regions = split(face).excluding([CONTROL_POINT_INDEX["pupil_l"]])
    assert all(CONTROL_POINT_INDEX["pupil_l"] in field.excluded for field in regions.fields)
    assert not matrix_of(face, regions)[:, CONTROL_POINT_INDEX["pupil_l"]].any()


@pytest.mark.slow
def test_a_symmetric_motion_moves_both_sides_alike(face: SheetFace) -> None:
    offsets = np.zeros((50, 3), dtype=np.float32)
    offsets[UPPER_LIP, 1], offsets[LOWER_LIP, 1] = 0.5, -1.0
    moved = (matrix_of(face, split(face)) @ offsets).reshape(-1, 81, 3)
    assert moved[..., 1] == pytest.approx(moved[:, ::-1, 1], abs=0.15)


@pytest.mark.slow
def test_touching_lips_are_separated(shut_face: SheetFace) -> None:
    mesh, points = shut_face.mesh, shut_face.points.copy()
    seam = np.flatnonzero((np.abs(mesh.vertices[:, 0]) < 2.1) & (np.abs(mesh.vertices[:, 1] + 4.4) < 1e-6))
    points[[1, 2, 5, 6, 7, 8]] = [[x, -4.4, z] for x, z in [(0, 5.61)] * 2 + [(0.9, 5.57), (-0.9, 5.57)] * 2]
    duplicates = np.full(len(mesh.vertices), -1)
    duplicates[seam] = len(mesh.vertices) + np.arange(len(seam))
    above = mesh.vertices[mesh.triangles].mean(axis=1)[:, 1] > -4.4
    triangles = mesh.triangles.copy()
    triangles[above] = np.where(duplicates[triangles[above]] >= 0, duplicates[triangles[above]], triangles[above])
    cut = replace(mesh, vertices=np.concatenate([mesh.vertices, mesh.vertices[seam]]), triangles=triangles)
    matrix = matrix_of(SheetFace(cut, points), split(SheetFace(cut, points)))
    offsets = np.zeros((50, 3), dtype=np.float32)
    offsets[UPPER_LIP, 1], offsets[LOWER_LIP, 1] = 0.5, -1.0
    middle = np.abs(mesh.vertices[seam, 0]) < 1.3
    assert (matrix @ offsets)[duplicates[seam][middle], 1] == pytest.approx(0.5, abs=0.2)
    assert (matrix @ offsets)[seam[middle], 1] == pytest.approx(-1.0, abs=0.3)
