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
from tests.animator.conftest import TO_FILE


def in_file(subject: FaceDocument) -> np.ndarray:
    assert subject.points is not None
    scale, shift = TO_FILE
    return np.asarray(subject.points * scale + shift)


def test_the_shipped_head_comes_with_all_it_has(subject: FaceDocument) -> None:
    assert subject.is_default and subject.rig is not None and subject.shapes is not None
    assert subject.points is not None
    np.testing.assert_array_equal(subject.to_file(subject.points), subject.points)


def test_a_mesh_of_any_unit_stands_in_the_middle_until_its_points_are_known(stranger: Path) -> None:
    opened = open_face_document(stranger)
    assert opened.points is None
    low, high = opened.mesh.vertices.min(axis=0), opened.mesh.vertices.max(axis=0)
    np.testing.assert_allclose((low + high) / 2, 0.0, atol=1e-6)
    assert high[1] - low[1] == pytest.approx(26.0)
    with pytest.raises(ConfError, match="not placed yet: place all of them, then press OK"):
        save_points(stranger.with_name("a.ppc"), opened)


def test_placed_points_bring_the_eyes_to_their_place_and_save_in_the_files_unit(
    stranger: Path, subject: FaceDocument, tmp_path: Path
) -> None:
    placed = with_points(open_face_document(stranger), in_file(subject))
    assert placed.points is not None and subject.points is not None
    np.testing.assert_allclose(placed.points[PUPILS].mean(axis=0), EYE_MIDPOINT, atol=1e-9)
    assert np.linalg.norm(placed.points[PUPILS[0]] - placed.points[PUPILS[1]]) == pytest.approx(6.4)
    save_points(tmp_path / "a.ppc", placed)
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc"), in_file(subject), atol=1e-5)
    again = with_points(placed, in_file(subject) + 0.5)
    assert again.rig is not None and len(again.rig.eyes) == 2
    np.testing.assert_allclose(again.to_file(again.mesh.vertices), placed.to_file(placed.mesh.vertices), atol=1e-6)


def test_points_in_one_place_are_no_face(stranger: Path) -> None:
    with pytest.raises(ConfError, match="do not fit this face: pupils, nose, lids and lips must lie apart"):
        with_points(open_face_document(stranger), np.ones((50, 3)))


def test_a_ppc_may_lie_elsewhere(stranger: Path, subject: FaceDocument, tmp_path: Path) -> None:
    write_ppc(tmp_path / "points.ppc", in_file(subject))
    assert open_face_document(stranger, tmp_path / "points.ppc").points is not None


def test_a_mesh_is_stood_upright_by_its_axes_and_goes_back_to_them(
    stranger: Path, subject: FaceDocument, tmp_path: Path
) -> None:
    """Z up and the nose towards -y, as modellers have it, without and with points."""
    lying = tmp_path / "lying.obj"
    back = axes_rotation("z", "-y")  # file to upright: its rows undo it
    write_obj(lying, subject.mesh, subject.mesh.vertices @ back)
    opened = open_face_document(lying, up="z", front="-y")
    upright = opened.mesh.vertices / opened.placement.scale
    np.testing.assert_allclose(upright - upright[0], subject.mesh.vertices - subject.mesh.vertices[0], atol=1e-4)
    assert open_face_document(lying, up="z").axes == opened.axes and open_face_document(lying).axes == ("y", "z")
    assert np.ptp(open_face_document(lying).mesh.vertices[:, 2]) > np.ptp(opened.mesh.vertices[:, 2]), (
        "it lay on its back"
    )
    assert subject.points is not None
    placed = with_points(opened, subject.points @ back)
    assert placed.points is not None
    np.testing.assert_allclose(placed.points, subject.points, atol=1e-3)
    np.testing.assert_allclose(placed.to_file(placed.points), subject.points @ back, atol=1e-9)
    with pytest.raises(ConfError, match="up y and front -y name one line: name two, such as y and z"):
        with_axes(opened, "y", "-y")
