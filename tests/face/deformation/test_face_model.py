import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP, PUPILS, UPPER_LIP, control_point_indices
from conf.face.deformation.blendshapes import load_shapes
from conf.face.deformation.face_model import DEFAULT_HEAD, DeformerOptions, FaceModel, build_face, load_face
from conf.face.deformation.kernels import KERNELS
from conf.face.formats.ppc import write_ppc
from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace

CORNERS = control_point_indices("inner_lip_corner", "outer_lip_corner")


@pytest.fixture(scope="module")
def head() -> FaceModel:
    return load_face()


def sculpted(head: FaceModel, *names: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the offsets of the vertices in some sculpted shapes together, and the displacements that say the same."""
    shapes = load_shapes(DEFAULT_HEAD.with_name("shapes.npz"), len(head.neutral))
    offsets = sum(shapes.offsets[shapes.names.index(name)] for name in names)
    nearest = SurfaceGraph(head.mesh.vertices, head.mesh.triangles).nearest_vertices(head.control_points, tolerance=0.0)
    return offsets, offsets[nearest] / head.fapu.lengths()


def rms_mm(errors: np.ndarray) -> float:
    return float(10 * np.sqrt((errors**2).sum(axis=1).mean()))


def test_a_face_that_does_not_move_is_the_neutral_one(head: FaceModel) -> None:
    still = head.deform(np.zeros((50, 3)))
    assert still.dtype == np.float32
    assert still == pytest.approx(head.neutral, abs=1e-5)


def test_the_default_head_is_in_model_units(head: FaceModel) -> None:
    assert head.fapu.es0 == pytest.approx(6.4, abs=0.05)
    assert head.smoothing == DeformerOptions().smoothing
    assert head.operator.shape == (len(head.neutral), 50)


@pytest.mark.parametrize(
    ("names", "limit_mm"),
    [(("jawOpen",), 1.0), (("mouthSmileLeft", "mouthSmileRight"), 0.8), (("eyeBlinkLeft", "eyeBlinkRight"), 1.8)],
)
def test_sculpted_shapes_come_back_from_their_control_points(
    head: FaceModel, names: tuple[str, ...], limit_mm: float
) -> None:
    offsets, displacements = sculpted(head, *names)
    skin = head.mesh.group_vertices("skin")
    assert rms_mm((head.deform(displacements) - head.neutral - offsets)[skin]) < limit_mm


def test_no_lip_moves_with_the_other(head: FaceModel) -> None:
    surface = SurfaceGraph(head.mesh.vertices, head.mesh.triangles)
    seeds = surface.nearest_vertices(head.control_points, tolerance=0.0)
    away = surface.distances(seeds[CORNERS], limit=1.0) >= 1.0
    for lip, other in ((UPPER_LIP, LOWER_LIP), (LOWER_LIP, UPPER_LIP)):
        on_lip = away & (surface.distances(seeds[lip], limit=1.0) < 0.5)
        assert on_lip.sum() > 20
        assert np.abs(head.operator[on_lip][:, other]).max() < 0.02


@pytest.mark.parametrize("closure", [0.5, 0.9, 1.0, 1.3])
@pytest.mark.parametrize("learned", [True, False])
def test_lids_never_sink_into_the_eyeball(head: FaceModel, closure: float, learned: bool) -> None:
    plain = build_face(
        head.mesh, head.control_points, DeformerOptions("linear", use_ridge_refinement=False), rig=head.rig
    )
    face = head if learned else plain
    displacements = np.zeros((50, 3))
    displacements[control_point_indices("eyelid_upper"), 1] = -1024 * closure
    moved = face.deform(displacements)
    assert face.rig is not None
    for eye in face.rig.eyes:
        distance = np.linalg.norm(moved[eye.lids] - eye.centre, axis=1)
        assert (distance > eye.clearance - 1e-4).all()


def test_eyes_turn_with_their_pupils_and_stay_round(head: FaceModel) -> None:
    displacements = np.zeros((50, 3))
    displacements[PUPILS, 0] = 0.3 / head.fapu.lengths()[PUPILS, 0]
    moved = head.deform(displacements)
    assert head.rig is not None
    for eye in head.rig.eyes:
        before, after = head.neutral[eye.vertices], moved[eye.vertices]
        radius = np.linalg.norm(before - eye.centre, axis=1)
        assert np.linalg.norm(after - eye.centre, axis=1) == pytest.approx(radius, abs=1e-4)
        front = before[:, 2].argmax()
        assert (after - before)[front, 0] == pytest.approx(0.3, abs=0.05)
    skin = head.mesh.group_vertices("skin")
    assert moved[skin] == pytest.approx(head.neutral[skin], abs=1e-5)


def test_lower_teeth_turn_rigidly_with_the_chin_and_upper_teeth_stay(head: FaceModel) -> None:
    moved = head.deform(sculpted(head, "jawOpen")[1])
    lower, upper = head.mesh.group_vertices("teeth_lower"), head.mesh.group_vertices("teeth_upper")
    assert moved[upper] == pytest.approx(head.neutral[upper], abs=1e-5)
    assert (moved - head.neutral)[lower, 1].mean() < -1.0
    spans = [np.linalg.norm(v[lower[:-1]] - v[lower[1:]], axis=1) for v in (head.neutral, moved)]
    assert spans[0] == pytest.approx(spans[1], abs=1e-4)


def test_the_chin_goes_where_it_is_told(head: FaceModel) -> None:
    displacements = sculpted(head, "jawOpen")[1]
    nearest = SurfaceGraph(head.mesh.vertices, head.mesh.triangles).nearest_vertices(head.control_points, tolerance=0.0)
    error = (head.deform(displacements)[nearest] - head.deformed_points(displacements))[0]
    assert np.linalg.norm(error) < 0.15


def test_noise_at_the_points_is_not_magnified(head: FaceModel) -> None:
    gain = np.linalg.norm(head.operator, axis=1)
    assert gain.mean() < 0.75
    assert gain.max() < 2.5


def test_an_array_may_be_given_to_write_to(head: FaceModel) -> None:
    displacements = np.random.default_rng(1).normal(size=(50, 3)).astype(np.float32) * 100
    out = np.empty_like(head.neutral)
    assert head.deform(displacements, out=out) is out
    assert out == pytest.approx(head.deform(displacements))


@pytest.mark.parametrize("kernel", KERNELS)
def test_every_kernel_makes_a_face(kernel: str, face: SheetFace) -> None:
    model = build_face(face.mesh, face.points, DeformerOptions(kernel))
    displacements = np.zeros((50, 3))
    displacements[CONTROL_POINT_INDEX["brow_inner_l"], 1] = 300
    raised = np.abs(model.deform(displacements) - model.neutral)
    assert 0.8 < raised.max() / (300 * model.fapu.lengths()[CONTROL_POINT_INDEX["brow_inner_l"], 1]) < 1.3


def test_an_unknown_kernel_is_the_callers_fault(face: SheetFace) -> None:
    with pytest.raises(ValueError, match=r"kernel must be one of gaussian, multiquadric, .*, got 'cubic'"):
        build_face(face.mesh, face.points, DeformerOptions("cubic"))


def write_face(folder: Path, face: SheetFace, scale: float) -> Path:
    lines = [f"v {x} {y} {z}" for x, y, z in face.mesh.vertices * scale]
    lines += ["f " + " ".join(str(i + 1) for i in triangle) for triangle in face.mesh.triangles]
    (folder / "own.obj").write_text("\n".join(lines))
    write_ppc(folder / "own.ppc", face.points * scale)
    return folder / "own.obj"


@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_a_face_in_any_unit_comes_to_model_units(tmp_path: Path, face: SheetFace, scale: float) -> None:
    model = load_face(write_face(tmp_path, face, scale))
    assert model.fapu.es0 == pytest.approx(6.4, abs=1e-3)
    assert model.control_points[PUPILS].mean(axis=0) == pytest.approx(
        load_face().control_points[PUPILS].mean(axis=0), abs=0.1
    )


def test_what_is_missing_is_named(tmp_path: Path, face: SheetFace) -> None:
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


def test_the_second_time_the_operator_comes_from_the_cache(
    face: SheetFace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = build_face(face.mesh, face.points)
    monkeypatch.setattr("conf.face.deformation.face_model.build_operator", None)  # may not be called again
    assert build_face(face.mesh, face.points).operator == pytest.approx(first.operator)
    with pytest.raises(TypeError):
        build_face(face.mesh, face.points, DeformerOptions(epsilon=2.0))


@pytest.mark.parametrize("turn", [[np.pi / 2, 0, 0], [0, 0, np.pi], [0, -np.pi / 2, 0]])
def test_a_face_that_lies_or_stands_on_its_head_is_turned_upright(turn: list[float], tmp_path: Path) -> None:
    upright = load_face()
    rotation = Rotation.from_rotvec(turn).as_matrix()
    lines = [f"v {x} {y} {z}" for x, y, z in upright.mesh.vertices @ rotation.T * 10]
    lines += [f"f {a} {b} {c}" for a, b, c in upright.mesh.triangles + 1]
    (tmp_path / "face.obj").write_text("\n".join(lines))
    write_ppc(tmp_path / "face.ppc", upright.control_points @ rotation.T * 10)
    face = load_face(tmp_path / "face.obj")
    np.testing.assert_allclose(face.control_points, upright.control_points, atol=0.02)


def test_deformed_vertices_go_back_to_the_files_unit(tmp_path: Path, face: SheetFace) -> None:
    model = load_face(write_face(tmp_path, face, 10.0))
    np.testing.assert_allclose(model.to_file_coordinates(model.neutral), face.mesh.vertices * 10, atol=1e-3)
    assert load_face().to_file_coordinates(load_face().neutral) == pytest.approx(load_face().neutral)
