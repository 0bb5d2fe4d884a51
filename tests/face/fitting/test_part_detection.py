"""The shipped head, its groups forgotten, is the oracle: what is found must be what its groups say."""

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


def found(mesh: Mesh, points: np.ndarray) -> DetectedParts:
    return detect_parts(mesh, points, SurfaceGraph(mesh.vertices, mesh.triangles))


@pytest.fixture(scope="module")
def head() -> Mesh:
    return load_mesh(DEFAULT_HEAD)


@pytest.fixture(scope="module")
def anatomy(head: Mesh) -> DetectedParts:
    return found(head, default_points())


@pytest.mark.parametrize("group", ["eye_l", "eye_r", "teeth_upper", "teeth_lower", "tongue"])
def test_shells_are_known_for_what_they_are(group: str, head: Mesh, anatomy: DetectedParts) -> None:
    assert anatomy.parts[group].tolist() == head.groups[group].tolist()


def test_the_inside_of_the_mouth_is_found_but_for_the_lips(head: Mesh, anatomy: DetectedParts) -> None:
    inside, true = set(anatomy.parts["mouth"].tolist()), set(head.groups["mouth"].tolist())
    assert len(inside & true) > 0.85 * len(true)
    assert len(inside - true) < 0.02 * len(true)


def test_an_eyeball_turns_about_its_middle(anatomy: DetectedParts) -> None:
    for group, centre in default_joints().eyes.items():
        assert np.linalg.norm(anatomy.eyes[group] - centre) < 0.1


def test_an_iris_of_its_own_goes_with_the_eyeball_and_a_beard_is_no_tooth(head: Mesh) -> None:
    iris = trimesh.creation.cylinder(
        0.6, 0.02, transform=trimesh.transformations.translation_matrix([3.2, 2.845, 3.75])
    )
    beard = trimesh.creation.box((3.0, 0.6, 0.3), transform=trimesh.transformations.translation_matrix([0, -5.6, 5.2]))
    vertices, triangles = head.vertices, head.triangles
    for part in (iris, beard):
        triangles = np.concatenate([triangles, np.asarray(part.faces, np.int32) + len(vertices)])
        vertices = np.concatenate([vertices, part.vertices])
    more = found(replace(head, vertices=vertices, triangles=triangles), default_points())
    added = np.arange(len(head.triangles), len(triangles))
    assert np.isin(added[: len(iris.faces)], more.parts["eye_l"]).all()
    assert not np.isin(added[len(iris.faces) :], np.concatenate(list(more.parts.values()))).any()


def test_a_sheet_has_neither_eyes_nor_teeth(face: SheetFace, shut_face: SheetFace) -> None:
    for sheet in (face, shut_face):
        assert found(sheet.mesh, sheet.points) == DetectedParts({}, {})


def test_a_head_without_eyes_and_teeth_has_none(head: Mesh) -> None:
    kept = np.isin(np.arange(len(head.triangles)), np.concatenate([head.groups["skin"], head.groups["mouth"]]))
    bare = found(submesh(head, kept), default_points())
    assert set(bare.parts) == {"mouth"}
    assert bare.eyes == {}
