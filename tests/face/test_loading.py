import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.rbf import KERNELS
from conf.face.formats.ppc import write_ppc
from conf.face.loading import build_face, load_face
from tests.support.sheet_face import SheetFace


@pytest.mark.slow
def test_the_default_head_is_in_model_units() -> None:
    head = load_face()
    assert head.fapu.es0 == pytest.approx(6.4, abs=0.05)
    assert head.smoothing == DeformerOptions().smoothing
    assert head.operator.shape == (len(head.neutral), 50)


@pytest.mark.slow
@pytest.mark.parametrize("kernel", KERNELS)
def test_every_kernel_moves_the_face_to_its_control_point(kernel: str, face: SheetFace) -> None:
    model = build_face(face.mesh, face.points, DeformerOptions(kernel))
    displacements = np.zeros((50, 3))
    displacements[CONTROL_POINT_INDEX["brow_inner_l"], 1] = 300
    offsets = np.abs(model.deform(displacements) - model.neutral)
    assert 0.8 < offsets.max() / (300 * model.fapu.lengths()[CONTROL_POINT_INDEX["brow_inner_l"], 1]) < 1.3


def test_an_unknown_kernel_raises(face: SheetFace) -> None:
    with pytest.raises(ValueError, match=r"kernel must be one of gaussian, multiquadric, .*, got 'cubic'"):
        build_face(face.mesh, face.points, DeformerOptions("cubic"))


def write_face(folder: Path, face: SheetFace, scale: float) -> Path:
    """Write the sheet as OBJ with its PPC; return the path of the OBJ."""
    lines = [f"v {x} {y} {z}" for x, y, z in face.mesh.vertices * scale]
    lines += ["f " + " ".join(str(i + 1) for i in triangle) for triangle in face.mesh.triangles]
    (folder / "own.obj").write_text("\n".join(lines))
    write_ppc(folder / "own.ppc", face.points * scale)
    return folder / "own.obj"


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_a_mesh_in_any_unit_is_scaled_to_model_units(tmp_path: Path, face: SheetFace, scale: float) -> None:
    model = load_face(write_face(tmp_path, face, scale))
    assert model.fapu.es0 == pytest.approx(6.4, abs=1e-3)
    assert model.control_points[PUPILS].mean(axis=0) == pytest.approx(
        load_face().control_points[PUPILS].mean(axis=0),
        abs=0.2,  # on eyeballs that are put in
    )


@pytest.mark.slow
def test_missing_or_wrong_control_points_are_reported(tmp_path: Path, face: SheetFace) -> None:
    path = write_face(tmp_path, face, 1.0)
    os.remove(path.with_suffix(".ppc"))
    with pytest.raises(FileFormatError, match=r"own\.ppc: expected a file; `conf fit .*own\.obj` makes it"):
        load_face(path)
    points = face.points.copy()
    points[PUPILS] = 0.0
    write_ppc(path.with_suffix(".ppc"), points)
    with pytest.raises(
        FileFormatError, match=r"own\.ppc: expected the points of this face: pupils, nose, lids and lips"
    ):
        load_face(path)


@pytest.mark.slow
def test_the_operator_is_read_from_the_cache_the_second_time(
    face: SheetFace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = build_face(face.mesh, face.points)
    monkeypatch.setattr("conf.face.deformation.operator_builder.build_operator", None)  # a second call would raise
    assert build_face(face.mesh, face.points).operator == pytest.approx(first.operator)
    with pytest.raises(TypeError):
        build_face(face.mesh, face.points, DeformerOptions(epsilon=2.0))


@pytest.mark.slow
@pytest.mark.parametrize("rotation_vector", [[np.pi / 2, 0, 0], [0, 0, np.pi], [0, -np.pi / 2, 0]])
def test_a_rotated_face_is_brought_upright(rotation_vector: list[float], tmp_path: Path) -> None:
    upright = load_face()
    rotation = Rotation.from_rotvec(rotation_vector).as_matrix()
    lines = [f"v {x} {y} {z}" for x, y, z in upright.mesh.vertices @ rotation.T * 10]
    lines += [f"f {a} {b} {c}" for a, b, c in upright.mesh.triangles + 1]
    (tmp_path / "face.obj").write_text("\n".join(lines))
    write_ppc(tmp_path / "face.ppc", upright.control_points @ rotation.T * 10)
    face = load_face(tmp_path / "face.obj")
    np.testing.assert_allclose(face.control_points, upright.control_points, atol=0.02)


@pytest.mark.slow
def test_vertices_can_be_returned_in_the_files_unit(tmp_path: Path, face: SheetFace) -> None:
    model = load_face(write_face(tmp_path, face, 10.0))
    own = model.to_file_coordinates(model.neutral)[: len(face.mesh.vertices)]  # eyes and teeth that are put in follow
    np.testing.assert_allclose(own, face.mesh.vertices * 10, atol=1e-3)
    assert load_face().to_file_coordinates(load_face().neutral) == pytest.approx(load_face().neutral)
