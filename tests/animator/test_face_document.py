from pathlib import Path

import numpy as np
import pytest

from conf.animator.face_document import FaceDocument, open_face_document, save_points, with_axes, with_points
from conf.errors import ConfError
from conf.face.control_points import PUPILS
from conf.face.default_head import EYE_MIDPOINT
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.mesh.axes import axes_rotation
from conf.output.obj_writer import write_obj
from tests.animator.conftest import FILE_OFFSET, FILE_SCALE


@pytest.fixture
def file_points(points: np.ndarray) -> np.ndarray:
    """The control points in the frame and unit of `unplaced_mesh`."""
    return np.asarray(points * FILE_SCALE + FILE_OFFSET)


def test_the_shipped_head_has_points_rig_and_blendshapes(document: FaceDocument, points: np.ndarray) -> None:
    assert document.is_default and document.rig is not None and document.shapes is not None
    np.testing.assert_array_equal(document.to_file_coordinates(points), points)


@pytest.mark.slow
def test_a_mesh_without_points_is_centred_and_scaled_to_a_head(unplaced_mesh: Path) -> None:
    document = open_face_document(unplaced_mesh)
    assert document.points is None
    low, high = document.mesh.vertices.min(axis=0), document.mesh.vertices.max(axis=0)
    np.testing.assert_allclose((low + high) / 2, 0.0, atol=1e-6)
    assert high[1] - low[1] == pytest.approx(26.0)
    with pytest.raises(ConfError, match="not placed yet: place all of them, then press OK"):
        save_points(unplaced_mesh.with_name("a.ppc"), document)
    with pytest.raises(ValueError, match="must have control points"):
        document.operator_builder()


@pytest.mark.slow
def test_points_align_the_eyes_and_are_saved_in_file_coordinates(
    unplaced_mesh: Path, file_points: np.ndarray, tmp_path: Path
) -> None:
    placed = with_points(open_face_document(unplaced_mesh), file_points)
    assert placed.points is not None
    np.testing.assert_allclose(placed.points[PUPILS].mean(axis=0), EYE_MIDPOINT, atol=1e-9)
    assert np.linalg.norm(placed.points[PUPILS[0]] - placed.points[PUPILS[1]]) == pytest.approx(6.4)
    save_points(tmp_path / "a.ppc", placed)
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc"), file_points, atol=1e-5)
    again = with_points(placed, file_points + 0.5)
    assert again.rig is not None and len(again.rig.eyes) == 2
    before, after = (d.to_file_coordinates(d.mesh.vertices) for d in (placed, again))
    np.testing.assert_allclose(after, before, atol=1e-6)


@pytest.mark.slow
def test_coinciding_points_are_refused(unplaced_mesh: Path) -> None:
    with pytest.raises(ConfError, match="do not fit this face: pupils, nose, lids and lips must lie apart"):
        with_points(open_face_document(unplaced_mesh), np.ones((50, 3)))


@pytest.mark.slow
def test_points_can_come_from_another_folder(unplaced_mesh: Path, file_points: np.ndarray, tmp_path: Path) -> None:
    write_ppc(tmp_path / "points.ppc", file_points)
    assert open_face_document(unplaced_mesh, tmp_path / "points.ppc").points is not None


@pytest.mark.slow
def test_axes_rotate_a_mesh_upright_and_back(document: FaceDocument, points: np.ndarray, tmp_path: Path) -> None:
    """Z up and the nose towards -y, as modelling programs have it, without and with points."""
    path = tmp_path / "z-up.obj"
    to_file = axes_rotation("z", "-y")  # right-multiplied: the inverse of file to upright
    write_obj(path, document.mesh, document.mesh.vertices @ to_file)
    upright = open_face_document(path, up="z", front="-y")
    vertices = upright.mesh.vertices / upright.file_to_model.scale
    np.testing.assert_allclose(vertices - vertices[0], document.mesh.vertices - document.mesh.vertices[0], atol=1e-4)
    assert open_face_document(path, up="z").axes == upright.axes
    default = open_face_document(path)
    assert default.axes == ("y", "z")
    assert np.ptp(default.mesh.vertices[:, 2]) > np.ptp(upright.mesh.vertices[:, 2]), "it lies on its back"
    placed = with_points(upright, points @ to_file)
    assert placed.points is not None
    np.testing.assert_allclose(placed.points, points, atol=1e-3)
    np.testing.assert_allclose(placed.to_file_coordinates(placed.points), points @ to_file, atol=1e-9)
    with pytest.raises(ConfError, match="up y and front -y name one line: name two, such as y and z"):
        with_axes(upright, "y", "-y")
