from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import LOWER_LIP, PUPILS, UPPER_LIP, control_point_indices
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.fapu import Fapu
from conf.face.loading import build_face, load_face
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import SimilarityTransform

CORNERS = control_point_indices("inner_lip_corner", "outer_lip_corner")


@pytest.fixture(scope="module")
def head() -> FaceModel:
    """Return the default head."""
    return load_face()


def blendshape_motion(head: FaceModel, *names: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the summed vertex offsets, cm, of some blendshapes and their displacements, FAPU units."""
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(head.neutral))
    offsets = sum(shapes.offsets[shapes.names.index(name)] for name in names)
    nearest = SurfaceGraph(head.mesh.vertices, head.mesh.triangles).nearest_vertices(head.control_points, tolerance=0.0)
    return offsets, offsets[nearest] / head.fapu.lengths()


def rms_mm(errors: np.ndarray) -> float:
    return float(10 * np.sqrt((errors**2).sum(axis=1).mean()))


def test_eyes_are_as_open_as_the_senders_and_shut_when_theirs_are(head: FaceModel) -> None:
    upper, lower = control_point_indices("eyelid_upper"), control_point_indices("eyelid_lower")
    vertices = [int(np.abs(head.neutral - head.control_points[point]).sum(axis=1).argmin()) for point in upper + lower]
    narrow = replace(head.fapu, irisd0=0.85 * head.fapu.irisd0)
    shut, half = np.zeros((50, 3)), np.zeros((50, 3))
    shut[upper, 1], half[upper, 1] = -1024, -512

    def gap(displacements: np.ndarray, sender: Fapu) -> float:
        heights = head.deform(displacements, sender=sender)[vertices, 1]
        return float((heights[:2] - heights[2:]).mean())

    at_rest = gap(np.zeros((50, 3)), narrow) / gap(np.zeros((50, 3)), head.fapu)
    assert at_rest == pytest.approx(0.85, abs=0.03)
    assert gap(half, narrow) == pytest.approx(0.5 * gap(np.zeros((50, 3)), narrow), abs=0.06)
    for sender in (narrow, head.fapu):
        assert gap(shut, sender) < 0.08


@pytest.mark.slow
def test_zero_displacements_give_the_neutral_face(head: FaceModel) -> None:
    vertices = head.deform(np.zeros((50, 3)))
    assert vertices.dtype == np.float32
    others = np.setdiff1d(np.arange(len(vertices)), head.mesh.group_vertices("teeth_upper"))  # behind the lip
    assert vertices[others] == pytest.approx(head.neutral[others], abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "limit_mm"),
    [(("jawOpen",), 1.0), (("mouthSmileLeft", "mouthSmileRight"), 0.8), (("eyeBlinkLeft", "eyeBlinkRight"), 1.8)],
)
def test_blendshapes_are_reproduced_from_their_control_points(
    head: FaceModel, names: tuple[str, ...], limit_mm: float
) -> None:
    offsets, displacements = blendshape_motion(head, *names)
    skin = head.mesh.group_vertices("skin")
    assert rms_mm((head.deform(displacements) - head.neutral - offsets)[skin]) < limit_mm


def test_one_lip_does_not_move_the_other(head: FaceModel) -> None:
    surface = SurfaceGraph(head.mesh.vertices, head.mesh.triangles)
    seeds = surface.nearest_vertices(head.control_points, tolerance=0.0)
    off_corners = surface.distances(seeds[CORNERS], limit=1.0) >= 1.0
    for lip, other in ((UPPER_LIP, LOWER_LIP), (LOWER_LIP, UPPER_LIP)):
        on_lip = off_corners & (surface.distances(seeds[lip], limit=1.0) < 0.5)
        assert on_lip.sum() > 20
        assert np.abs(head.operator[on_lip][:, other]).max() < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("closure", [0.5, 0.9, 1.0, 1.3])
@pytest.mark.parametrize("refined", [True, False])
def test_lids_stay_outside_the_eyeball(head: FaceModel, closure: float, refined: bool) -> None:
    unrefined = build_face(
        head.mesh, head.control_points, DeformerOptions("linear", use_ridge_refinement=False), rig=head.rig
    )
    face = head if refined else unrefined
    displacements = np.zeros((50, 3))
    displacements[control_point_indices("eyelid_upper"), 1] = -1024 * closure
    moved = face.deform(displacements)
    assert face.rig is not None
    for eye in face.rig.eyes:
        distance = np.linalg.norm(moved[eye.lids] - eye.centre, axis=1)
        assert (distance > eye.clearance - 1e-4).all()


def test_eyeballs_rotate_rigidly_with_their_pupils(head: FaceModel) -> None:
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


def test_lower_teeth_rotate_rigidly_with_the_chin_and_upper_teeth_rise_behind_the_lip(head: FaceModel) -> None:
    moved = head.deform(blendshape_motion(head, "jawOpen")[1])
    lower, upper = head.mesh.group_vertices("teeth_lower"), head.mesh.group_vertices("teeth_upper")
    rise = (moved - head.neutral)[upper]
    assert rise == pytest.approx(np.tile(rise[0], (len(upper), 1)), abs=1e-5)
    assert rise[0, [0, 2]] == pytest.approx([0, 0], abs=1e-5)
    assert 0.2 < rise[0, 1] < 0.4
    assert (moved - head.neutral)[lower, 1].mean() < -1.0
    spans = [np.linalg.norm(v[lower[:-1]] - v[lower[1:]], axis=1) for v in (head.neutral, moved)]
    assert spans[0] == pytest.approx(spans[1], abs=1e-4)


@pytest.mark.parametrize("long", [0.8, 1.0, 1.25])
def test_an_opening_keeps_its_ratio_to_the_width_of_the_eyes(head: FaceModel, long: float) -> None:
    """The distance from nose to mouth differs between faces; that of the sender's is in its FAPU."""
    sender = replace(head.fapu, mns0=head.fapu.mns0 * long)
    displacements = np.zeros((50, 3))
    displacements[LOWER_LIP, 1] = -1.0 / sender.lengths()[LOWER_LIP, 1]  # by 1 cm
    lips = LipOpening(head)
    opened = lips.measure(head.deform(displacements, sender=sender))
    wide = np.ptp(head.control_points[control_point_indices("eye_outer_corner"), 0]) / head.fapu.es0 / 1.39
    assert opened == pytest.approx(wide, abs=0.06)


@pytest.mark.slow
def test_the_chin_reaches_its_control_point(head: FaceModel) -> None:
    displacements = blendshape_motion(head, "jawOpen")[1]
    nearest = SurfaceGraph(head.mesh.vertices, head.mesh.triangles).nearest_vertices(head.control_points, tolerance=0.0)
    error = (head.deform(displacements)[nearest] - head.deformed_points(displacements))[0]
    assert np.linalg.norm(error) < 0.15


def test_noise_of_the_control_points_is_not_amplified(head: FaceModel) -> None:
    gain = np.linalg.norm(head.operator, axis=1)
    assert gain.mean() < 0.75
    assert gain.max() < 2.5


@pytest.mark.slow
def test_without_a_rig_the_deformation_is_the_operator_alone(head: FaceModel) -> None:
    face = replace(head, rig=None)
    displacements = np.random.default_rng(2).normal(size=(50, 3)) * 100
    expected = head.neutral + head.operator @ (displacements * head.fapu.lengths())
    assert face.deform(displacements) == pytest.approx(expected, abs=1e-4)


def test_deformed_points_are_the_neutral_ones_plus_fapu_lengths(head: FaceModel) -> None:
    displacements = np.random.default_rng(3).normal(size=(50, 3)) * 100
    points = head.deformed_points(displacements)
    assert points.dtype == np.float32
    assert points == pytest.approx(head.control_points + displacements * head.fapu.lengths(), abs=1e-5)


def test_file_coordinates_are_those_before_the_face_was_brought_to_model_centimetres(head: FaceModel) -> None:
    face = replace(head, file_to_model=SimilarityTransform(np.eye(3)[[1, 2, 0]], 0.1, np.array([1.0, -2.0, 3.0])))
    positions = face.file_to_model.apply(head.control_points)
    found = face.to_file_coordinates(positions.astype(np.float32))
    assert found.dtype == np.float64
    assert found == pytest.approx(head.control_points, abs=1e-4)


@pytest.mark.slow
def test_deform_writes_to_the_given_array(head: FaceModel) -> None:
    displacements = np.random.default_rng(1).normal(size=(50, 3)).astype(np.float32) * 100
    out = np.empty_like(head.neutral)
    assert head.deform(displacements, out=out) is out
    assert out == pytest.approx(head.deform(displacements))
