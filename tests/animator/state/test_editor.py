from pathlib import Path

from conf.animator.file_export import check_output, parse_fps, parse_size
from conf.animator.state.editor import CURRENT_VIEW, MUSCLES, PRESETS, EditorState, MuscleState, muscle_names
from conf.face.deformation.facial_muscles import MUSCLE_COURSES, SPHINCTER

MUSCLE_NAMES = (*(f"{name}_{side}" for name in MUSCLE_COURSES for side in "lr"), SPHINCTER)


def test_the_default_fields_can_be_exported() -> None:
    fields = EditorState().fields
    check_output(Path(fields.output))
    assert parse_size(fields.size) == (1280, 720) and parse_fps(fields.fps) == 30.0 and fields.source == CURRENT_VIEW


def test_a_muscle_contracts_on_both_sides_or_one() -> None:
    symmetric = MuscleState().contract("corrugator_l", 0.3)
    assert symmetric.contractions == {"corrugator_l": 0.3, "corrugator_r": 0.3}
    assert MuscleState(symmetric=False).contract("corrugator_r", 0.3).contractions == {"corrugator_r": 0.3}
    assert MuscleState().contract("orbicularis_oris", 0.3).contractions == {"orbicularis_oris": 0.3}
    assert sorted(name for stem in MUSCLES for name in muscle_names(stem)) == sorted(MUSCLE_NAMES)


def test_every_preset_uses_known_muscles() -> None:
    for preset in PRESETS:
        state = MuscleState().with_preset(preset)
        assert set(state.contractions) <= set(MUSCLE_NAMES) and state.active
