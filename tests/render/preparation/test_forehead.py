"""The forehead is found by its position on the face."""

import numpy as np
import pytest

from conf.face.control_points import control_point_indices
from conf.face.deformation.face_model import FaceModel
from conf.render.preparation.forehead import ABOVE, BELOW, SIDE, forehead_positions, on_forehead

BROWS = control_point_indices("brow_inner")


def test_positions_are_measured_from_the_middle_between_the_brows(face: FaceModel) -> None:
    positions, mesh = forehead_positions(face.mesh, face.control_points), face.mesh
    middle = face.control_points[BROWS].mean(axis=0)
    np.testing.assert_allclose(positions + middle, mesh.vertices[mesh.render_vertices], atol=1e-5)


def test_the_forehead_covers_what_furrows_reach_in_front_and_no_more(face: FaceModel) -> None:
    mesh = face.mesh
    positions = forehead_positions(mesh, face.control_points)
    found = on_forehead(positions, mesh.render_triangles)
    assert 0 < found.sum() < len(found) / 2
    corners = positions[mesh.render_triangles]
    inside = (np.abs(corners[..., 0]) < SIDE) & (corners[..., 1] > -BELOW) & (corners[..., 1] < ABOVE)
    in_front = corners[..., 2] > -1.0
    assert found[(inside & in_front).any(axis=1)].all()
    assert not found[(corners[..., 2] < -5.0).all(axis=1)].any() and not found[(~inside).all(axis=1)].any()


@pytest.mark.parametrize("shift", [(20.0, 0.0, 0.0), (0.0, -10.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, -10.0)])
def test_skin_that_is_elsewhere_has_none(face: FaceModel, shift: tuple[float, float, float]) -> None:
    x, y, z = forehead_positions(face.mesh, face.control_points).T
    found = np.flatnonzero((np.abs(x) < 4) & (np.abs(y) < 1) & (z > -2))[None]
    positions = np.stack([x, y, z], axis=1)
    triangles = found[:, :3].astype(np.int32)
    assert on_forehead(positions, triangles).all()
    assert not on_forehead(positions + np.array(shift, np.float32), triangles).any()
