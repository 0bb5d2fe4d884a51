from conf.animator.state.muscles import MUSCLES, PRESETS, MuscleState, muscle_names
from conf.face.deformation.facial_muscles import MUSCLE_NAMES


def test_muscles_contract_on_both_sides_or_one() -> None:
    both = MuscleState().contract("corrugator_l", 0.3)
    assert both.contractions == {"corrugator_l": 0.3, "corrugator_r": 0.3}
    assert MuscleState(symmetric=False).contract("corrugator_r", 0.3).contractions == {"corrugator_r": 0.3}
    assert MuscleState().contract("orbicularis_oris", 0.3).contractions == {"orbicularis_oris": 0.3}
    assert sorted(name for stem in MUSCLES for name in muscle_names(stem)) == sorted(MUSCLE_NAMES)


def test_every_pose_is_of_muscles_that_are_there() -> None:
    for pose in PRESETS:
        assert set(MuscleState().with_preset(pose).contractions) <= set(MUSCLE_NAMES)
        assert MuscleState().with_preset(pose).active
