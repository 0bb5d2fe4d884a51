"""The shipped head without its eyeballs: the new ones lie where its own were."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import PUPILS
from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.fitting.eyeball_insertion import insert_eyeballs
from conf.face.fitting.part_detection import detect_parts
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def blind() -> Mesh:
    head = load_mesh(DEFAULT_HEAD)
    kept = np.zeros(len(head.triangles), bool)
    for name in ("skin", "mouth"):
        kept[head.groups[name]] = True
    return submesh(head, kept)


@pytest.mark.parametrize("inside_out", [False, True])
def test_eyeballs_come_where_they_were_and_are_found_again(blind: Mesh, inside_out: bool) -> None:
    if inside_out:
        blind = replace(blind, triangles=blind.triangles[:, ::-1], render_triangles=blind.render_triangles[:, ::-1])
    seeing, points = insert_eyeballs(blind, default_points())
    assert seeing.vertices[: len(blind.vertices)].tolist() == blind.vertices.tolist()
    anatomy = detect_parts(seeing, points, SurfaceGraph(seeing.vertices, seeing.triangles))
    for (name, centre), pupil in zip(default_joints().eyes.items(), points[PUPILS], strict=True):
        assert np.linalg.norm(anatomy.eyes[name] - centre) < 0.4
        assert pupil == pytest.approx(anatomy.eyes[name] + [0, 0, 1.55], abs=1e-6)
        corners = seeing.vertices[seeing.triangles[anatomy.parts[name]]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        outwards = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - anatomy.eyes[name]) > 0
        assert (outwards != inside_out).all()


def test_the_lids_lie_before_them(blind: Mesh) -> None:
    points = insert_eyeballs(blind, default_points())[1]
    for side, pupil in (("l", PUPILS[0]), ("r", PUPILS[1])):
        centre = points[pupil] - np.array([0, 0, 1.55])
        lids = default_points()[[12, 14] if side == "l" else [13, 15]]
        assert (np.linalg.norm(lids - centre, axis=1) > 1.55).all()


def test_eyes_that_are_there_or_shut_are_left_alone(face: SheetFace) -> None:
    head = load_mesh(DEFAULT_HEAD)
    for mesh, points in ((head, default_points()), (face.mesh, face.points)):
        same, unmoved = insert_eyeballs(mesh, points)
        assert same is mesh
        assert unmoved.tolist() == points.tolist()
