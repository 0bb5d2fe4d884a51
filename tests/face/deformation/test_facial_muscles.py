from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.facial_muscles import (
    MUSCLE_COURSES,
    RING_AXES,
    RING_DEPTH,
    RING_PROTRUSION,
    SPHINCTER,
    MuscleDeformer,
    build_muscles,
)
from conf.face.deformation.waters_muscles import LinearMuscle, Sphincter
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


def test_the_ring_lies_around_the_mouth_in_half_mouth_widths() -> None:
    points = np.random.default_rng(1).normal(size=(CONTROL_POINT_COUNT, 3))
    points[CONTROL_POINT_INDEX["outer_lip_corner_l"]] = 5.0, 1.0, 0.0
    points[CONTROL_POINT_INDEX["outer_lip_corner_r"]] = 1.0, 1.0, 0.0
    points[CONTROL_POINT_INDEX["outer_lip_upper_mid"]] = 3.0, 2.0, 1.5
    points[CONTROL_POINT_INDEX["outer_lip_lower_mid"]] = 3.0, -1.0, -2.5
    ring = build_muscles(points)[SPHINCTER]
    assert isinstance(ring, Sphincter)
    assert ring.centre.tolist() == [3.0, 0.5, -0.5]
    assert ring.axes[0] == pytest.approx([2.0 * RING_AXES[0], 0.0, 0.0])
    assert ring.axes[1] == pytest.approx([0.0, 2.0 * RING_AXES[1] * 0.6, 2.0 * RING_AXES[1] * 0.8])
    assert (ring.depth, ring.protrusion) == (2.0 * RING_DEPTH, 2.0 * RING_PROTRUSION)
    points[CONTROL_POINT_INDEX["outer_lip_upper_mid"], 0] += 0.7  # a crooked mouth
    crooked = build_muscles(points)[SPHINCTER]
    assert isinstance(crooked, Sphincter)
    assert crooked.axes[0] @ crooked.axes[1] == pytest.approx(0.0, abs=1e-12)


def test_a_muscle_has_the_angle_and_the_reach_of_its_course() -> None:
    muscles = build_muscles(np.random.default_rng(1).normal(size=(CONTROL_POINT_COUNT, 3)))
    for name, course in MUSCLE_COURSES.items():
        for side in "lr":
            muscle = muscles[f"{name}_{side}"]
            assert isinstance(muscle, LinearMuscle)
            assert (muscle.angle, muscle.start, muscle.end) == (np.radians(course.angle), course.start, course.end)


@pytest.mark.slow
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
    assert opened.dtype == np.float32
    assert (opened[teeth, 1] < face.neutral[teeth, 1] - 0.5).all()


def test_muscles_pull_what_the_jaw_has_moved() -> None:
    face, muscles = head()
    pulled = muscles.deform({"depressor_labii_l": 0.3})
    both = muscles.deform({"depressor_labii_l": 0.3}, jaw=0.2)
    np.testing.assert_allclose(both - pulled, muscles.deform({}, jaw=0.2) - face.neutral, atol=1e-5)


@pytest.mark.slow
def test_a_face_without_a_jaw_is_moved_by_its_muscles_only() -> None:
    face = replace(head()[0], rig=None)
    np.testing.assert_array_equal(MuscleDeformer(face).deform({}, jaw=0.2), face.neutral)
