"""Parts of the default head are detected without its groups and compared with them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.fitting.part_detection import DetectedParts, detect_parts
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace


def detect(mesh: Mesh, points: np.ndarray) -> DetectedParts:
    return detect_parts(mesh, points, SurfaceGraph(mesh.vertices, mesh.triangles))


@pytest.fixture(scope="module")
def head() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.fixture(scope="module")
def detected(head: Mesh) -> DetectedParts:
    return detect(head, default_points())


@pytest.mark.slow
@pytest.mark.parametrize("group", ["eye_l", "eye_r", "teeth_upper", "teeth_lower", "tongue"])
def test_eyes_teeth_and_tongue_match_their_groups(group: str, head: Mesh, detected: DetectedParts) -> None:
    assert detected.parts[group].tolist() == head.groups[group].tolist()


def test_the_inside_of_the_mouth_matches_its_group_without_the_lips(head: Mesh, detected: DetectedParts) -> None:
    inside, expected = set(detected.parts["mouth"].tolist()), set(head.groups["mouth"].tolist())
    assert len(inside & expected) > 0.85 * len(expected)
    assert len(inside - expected) < 0.02 * len(expected)


def test_eye_centres_match_the_rig(detected: DetectedParts) -> None:
    for group, centre in default_joints().eyes.items():
        assert np.linalg.norm(detected.eyes[group] - centre) < 0.1


@pytest.mark.slow
def test_a_separate_iris_belongs_to_the_eyeball_and_a_beard_is_no_tooth(head: Mesh) -> None:
    iris = trimesh.creation.cylinder(
        0.6, 0.02, transform=trimesh.transformations.translation_matrix([3.2, 2.845, 3.75])
    )
    beard = trimesh.creation.box((3.0, 0.6, 0.3), transform=trimesh.transformations.translation_matrix([0, -5.6, 5.2]))
    vertices, triangles = head.vertices, head.triangles
    for part in (iris, beard):
        triangles = np.concatenate([triangles, np.asarray(part.faces, np.int32) + len(vertices)])
        vertices = np.concatenate([vertices, part.vertices])
    parts = detect(replace(head, vertices=vertices, triangles=triangles), default_points()).parts
    added = np.arange(len(head.triangles), len(triangles))
    assert np.isin(added[: len(iris.faces)], parts["eye_l"]).all()
    assert not np.isin(added[len(iris.faces) :], np.concatenate(list(parts.values()))).any()


@pytest.mark.slow
def test_a_sheet_has_no_parts(face: SheetFace, shut_face: SheetFace) -> None:
    for sheet in (face, shut_face):
        assert detect(sheet.mesh, sheet.points) == DetectedParts({}, {})


def test_only_the_mouth_is_detected_without_eyes_and_teeth(head: Mesh) -> None:
    kept = np.isin(np.arange(len(head.triangles)), np.concatenate([head.groups["skin"], head.groups["mouth"]]))
    bare = detect(submesh(head, kept), default_points())
    assert set(bare.parts) == {"mouth"}
    assert bare.eyes == {}
