"""Eyes are cut into a sheet that has none."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import default_points
from conf.face.fitting.eye_opening import open_eyes
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import triangle_edges
from tests.support.modified_heads import EYEBALLS, head_without
from tests.support.sheet_face import SheetFace


@pytest.mark.slow
def test_an_opening_is_cut_between_the_lids(shut_face: SheetFace) -> None:
    mesh, points = shut_face.mesh, shut_face.points
    opened = open_eyes(mesh, points)
    assert opened.vertices[: len(mesh.vertices)].tolist() == mesh.vertices.tolist()
    for side in "lr":
        lids = points[[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"] for lid in ("upper", "lower")]]
        heights = np.linspace(lids[1, 1] - 0.3, lids[0, 1] + 0.3, 60)
        column = np.stack([np.full(60, lids[0, 0] + 0.0137), heights], axis=1)
        missed = cast_front_rays(column, opened.vertices, opened.triangles).triangles < 0
        inside = (heights > lids[1, 1] + 0.05) & (heights < lids[0, 1] - 0.05)
        outside = (heights < lids[1, 1] - 0.05) | (heights > lids[0, 1] + 0.05)
        assert missed[inside].all() and not missed[outside].any()
    counts = np.unique(np.sort(triangle_edges(opened.triangles), axis=1), axis=0, return_counts=True)[1]
    assert counts.max() == 2


@pytest.mark.slow
def test_eyes_with_eyeballs_or_sockets_and_closed_lids_are_left_unchanged(shut_face: SheetFace) -> None:
    for mesh in (head_without(), head_without(*EYEBALLS)):
        assert open_eyes(mesh, default_points()) is mesh
    closed = shut_face.points.copy()
    for side in "lr":
        closed[CONTROL_POINT_INDEX[f"eyelid_upper_{side}"]] = closed[CONTROL_POINT_INDEX[f"eyelid_lower_{side}"]]
    assert open_eyes(shut_face.mesh, closed) is shut_face.mesh


@pytest.mark.slow
def test_textured_eyes_are_cut_in_the_skin_and_left_if_they_are_parts_of_their_own(shut_face: SheetFace) -> None:
    """A disc before the skin, as cartoons have it, is no eyeball."""
    mesh, points = shut_face.mesh, shut_face.points
    numbers = np.zeros(len(mesh.triangles), np.int32)
    textured = replace(mesh, materials=(MeshMaterial(image=np.zeros((1, 1, 4), np.uint8)),), triangle_materials=numbers)
    assert open_eyes(textured, points) is not textured
    discs, triangles = [mesh.vertices], [mesh.triangles]
    for side in "lr":
        lids = points[[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"] for lid in ("upper", "lower")]].mean(axis=0)
        triangles.append(np.array([[0, 1, 2]], np.int32) + sum(map(len, discs)))
        discs.append(lids + np.array([[-0.35, -0.2, 0.5], [0.3, -0.25, 0.5], [0.05, 0.4, 0.5]]))
    rows = np.arange(sum(map(len, discs)), dtype=np.int32)
    own = replace(
        textured, vertices=np.concatenate(discs), triangles=np.concatenate(triangles), uvs=np.zeros((len(rows), 2)),
        render_vertices=rows, render_triangles=np.concatenate(triangles),
        triangle_materials=np.zeros(len(numbers) + 2, np.int32),
    )  # fmt: skip
    assert open_eyes(own, points) is own
