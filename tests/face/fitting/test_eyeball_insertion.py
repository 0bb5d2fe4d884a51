"""Eyeballs inserted into the default head without its own lie where its own were."""

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
from conf.face.mesh.winding import triangle_normals
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def eyeless() -> Mesh:
    head = load_mesh(DEFAULT_HEAD)
    kept = np.zeros(len(head.triangles), bool)
    for name in ("skin", "mouth"):
        kept[head.groups[name]] = True
    return submesh(head, kept)


@pytest.mark.slow
@pytest.mark.parametrize("inside_out", [False, True])
def test_inserted_eyeballs_are_detected_where_the_originals_were(eyeless: Mesh, inside_out: bool) -> None:
    if inside_out:
        eyeless = replace(
            eyeless, triangles=eyeless.triangles[:, ::-1], render_triangles=eyeless.render_triangles[:, ::-1]
        )
    filled, points = insert_eyeballs(eyeless, default_points())
    assert filled.vertices[: len(eyeless.vertices)].tolist() == eyeless.vertices.tolist()
    detected = detect_parts(filled, points, SurfaceGraph(filled.vertices, filled.triangles))
    for (name, centre), pupil in zip(default_joints().eyes.items(), points[PUPILS], strict=True):
        assert np.linalg.norm(detected.eyes[name] - centre) < 0.4
        assert pupil == pytest.approx(detected.eyes[name] + [0, 0, 1.55], abs=1e-6)
        triangles = filled.triangles[detected.parts[name]]
        normals, corners = triangle_normals(filled.vertices, triangles), filled.vertices[triangles]
        outwards = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - detected.eyes[name]) > 0
        assert (outwards != inside_out).all()


def test_inserted_eyeballs_lie_behind_the_lids(eyeless: Mesh) -> None:
    points = insert_eyeballs(eyeless, default_points())[1]
    for side, pupil in (("l", PUPILS[0]), ("r", PUPILS[1])):
        centre = points[pupil] - np.array([0, 0, 1.55])
        lids = default_points()[[12, 14] if side == "l" else [13, 15]]
        assert (np.linalg.norm(lids - centre, axis=1) > 1.55).all()


@pytest.mark.slow
def test_existing_or_closed_eyes_are_left_unchanged(face: SheetFace) -> None:
    head = load_mesh(DEFAULT_HEAD)
    for mesh, points in ((head, default_points()), (face.mesh, face.points)):
        same, unmoved = insert_eyeballs(mesh, points)
        assert same is mesh
        assert unmoved.tolist() == points.tolist()
