from functools import cache

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.facial_muscles import MUSCLE_COURSES, SPHINCTER, MuscleDeformer, build_muscles
from conf.face.loading import load_face

MOVES = [  # muscle, control point, direction of its offset on the left side
    ("zygomatic_major", "outer_lip_corner", [1, 1, 0]),
    ("risorius", "outer_lip_corner", [1, 0, 0]),
    ("depressor_anguli", "outer_lip_corner", [0, -1, 0]),
    ("levator_labii", "outer_lip_upper", [0, 1, 0]),
    ("levator_nasi", "nostril_border", [0, 1, 0]),
    ("depressor_labii", "outer_lip_lower", [0, -1, 0]),
    ("frontalis_inner", "brow_inner", [0, 1, 0]),
    ("frontalis_outer", "brow_top", [0, 1, 0]),
    ("corrugator", "brow_inner", [-1, -1, 0]),
]


@cache
def head() -> tuple[FaceModel, MuscleDeformer]:
    face = load_face()
    return face, MuscleDeformer(face)


def vertex(name: str) -> int:
    face, _ = head()
    return int(np.linalg.norm(face.mesh.vertices - face.control_points[CONTROL_POINT_INDEX[name]], axis=1).argmin())


@pytest.mark.slow
def test_there_are_nine_pairs_and_the_sphincter() -> None:
    muscles = build_muscles(head()[0].control_points)
    assert set(muscles) == {SPHINCTER, *(f"{name}_{side}" for name in MUSCLE_COURSES for side in "lr")}
    assert len(muscles) == 19
    for course in MUSCLE_COURSES.values():
        assert sum(course.root.values()) == pytest.approx(1.0)
        assert sum(course.insertion.values()) == pytest.approx(1.0)


def test_relaxed_muscles_give_the_neutral_face() -> None:
    face, muscles = head()
    np.testing.assert_array_equal(muscles.deform({}), face.neutral)


@pytest.mark.parametrize(("muscle", "point", "direction"), MOVES)
def test_each_muscle_pulls_in_its_anatomical_direction(muscle: str, point: str, direction: list[int]) -> None:
    face, muscles = head()
    offset = (muscles.deform({f"{muscle}_l": 0.2}) - face.neutral)[vertex(f"{point}_l")]
    assert (offset[np.array(direction) != 0] * np.array(direction)[np.array(direction) != 0] > 0.02).all()


@pytest.mark.parametrize(("muscle", "still"), [("levator_labii_l", "lower"), ("depressor_labii_l", "upper")])
def test_a_lip_muscle_leaves_the_other_lip_still(muscle: str, still: str) -> None:
    face, muscles = head()
    offsets = np.linalg.norm(muscles.deform({muscle: 0.3}) - face.neutral, axis=1)
    assert offsets[vertex(f"inner_lip_{still}_l")] < 0.02
    assert offsets.max() > 0.3


def test_muscles_leave_rigid_parts_still_and_the_jaw_moves_the_lower_teeth() -> None:
    face, muscles = head()
    assert face.rig is not None
    pulled = muscles.deform(dict.fromkeys(muscles.muscles.names, 0.3))
    np.testing.assert_array_equal(pulled[face.rig.rigid], face.neutral[face.rig.rigid])
    opened = muscles.deform({}, jaw=0.2)
    teeth = face.mesh.group_vertices("teeth_lower")
    assert (opened[teeth, 1] < face.neutral[teeth, 1] - 0.5).all()
