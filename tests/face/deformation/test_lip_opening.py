import numpy as np
import pytest

from conf.face.animation.action_units import combine_action_units
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import INNER_LIPS, LipOpening
from conf.face.loading import load_face
from conf.face.mesh.mesh import Mesh
from tests.support.modified_heads import MOUTH, face_without


def two_lips(gap: float) -> FaceModel:
    """Return two vertices for each lip, at the same places for a gap of 0: the lower lip's come first."""
    points = np.random.default_rng(1).normal(size=(50, 3)) + 20.0
    points[INNER_LIPS] = [[0.0, gap, 0.0], [0.0, 0.0, 0.0]]
    vertices = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.0, gap, 0], [0.1, gap, 0]])
    operator = np.zeros((4, 50), np.float32)
    operator[2:, INNER_LIPS[0]] = operator[:2, INNER_LIPS[1]] = [0.9, 0.6]
    triangles = np.array([[0, 1, 2], [1, 2, 3]], np.int32)
    rows = np.arange(4, dtype=np.int32)
    return FaceModel(Mesh(vertices, triangles, np.zeros((4, 2)), rows, triangles, {}), points, operator)


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.2])
def test_each_lip_is_measured_though_both_touch(gap: float) -> None:
    face = two_lips(gap)
    lips = LipOpening(face)
    assert lips.measure(face.neutral) == pytest.approx(0.0, abs=1e-6)
    opened = face.neutral - np.array([[0, 0.5, 0]] * 2 + [[0, 0, 0]] * 2, np.float32)
    assert lips.measure(opened) == pytest.approx(0.5, abs=1e-6)


def test_a_mouth_that_is_open_in_the_file_counts_as_open() -> None:
    face = two_lips(0.8)
    assert LipOpening(face).measure(face.neutral) == pytest.approx(0.55)


@pytest.mark.slow
def test_a_smile_opens_the_lips_of_heads_and_a_blink_does_not() -> None:
    for face in (load_face(), face_without(*MOUTH)):
        lips = LipOpening(face)
        measured = {unit: lips.measure(face.deform(combine_action_units({unit: 1.0}))) for unit in (45, 26)}
        assert abs(measured[45]) < 0.02 and measured[26] > 1.5
        points = face.control_points[:, 1]
        upper, lower = (CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower"))
        assert points[upper] >= points[lower] - 0.1
