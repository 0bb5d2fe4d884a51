import numpy as np
import pytest

from conf.errors import ConfError, FileFormatError
from conf.face.animation.action_units import (
    ACTION_UNIT_NAMES,
    ASSETS,
    EMOTIONS,
    action_unit_label,
    combine_action_units,
    load_action_units,
    load_emotions,
    load_expression,
)
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.formats.epc import read_epc
from conf.face.symmetry import mirror_motion

DIRECTIONS = [  # action unit, control point, axis, sign, according to FACS
    (1, "brow_inner_l", 1, 1), (2, "brow_outer_l", 1, 1), (4, "brow_inner_l", 1, -1), (4, "brow_inner_l", 0, -1),
    (5, "eyelid_upper_l", 1, 1), (6, "cheekbone_l", 1, 1), (7, "eyelid_lower_l", 1, 1), (9, "nostril_border_l", 1, 1),
    (10, "outer_lip_upper_l", 1, 1), (12, "outer_lip_corner_l", 1, 1), (12, "outer_lip_corner_l", 0, 1),
    (14, "outer_lip_corner_l", 0, 1), (15, "outer_lip_corner_l", 1, -1), (16, "outer_lip_lower_l", 1, -1),
    (20, "outer_lip_corner_l", 0, 1), (23, "outer_lip_upper_mid", 1, -1), (26, "chin_bottom", 1, -1),
    (45, "eyelid_upper_l", 1, -1),
]  # fmt: skip
THESIS_TABLE_3_3 = {
    "joy": {1, 6, 12, 14},
    "surprise": {1, 2, 5, 15, 16, 20, 26},
    "doubt": {2, 6, 7, 14},
    "fear": {1, 2, 4, 5, 15, 20, 26},
    "anger": {2, 4, 7, 9, 10, 20, 26},
    "sadness": {1, 4, 15, 23},
}


@pytest.mark.parametrize(("unit", "point", "axis", "sign"), DIRECTIONS)
def test_a_unit_moves_points_in_the_direction_of_facs(unit: int, point: str, axis: int, sign: int) -> None:
    assert load_action_units()[unit][CONTROL_POINT_INDEX[point], axis] * sign > 5


def test_every_unit_is_symmetric() -> None:
    for displacements in load_action_units().values():
        np.testing.assert_allclose(mirror_motion(displacements), displacements, atol=0.2)  # the file has one decimal


def test_emotions_have_the_units_of_the_thesis() -> None:
    assert {name: set(intensities) for name, intensities in EMOTIONS.items()} == THESIS_TABLE_3_3


@pytest.mark.parametrize("name", EMOTIONS)
def test_the_files_match_the_table(name: str) -> None:
    np.testing.assert_allclose(load_emotions()[name], combine_action_units(EMOTIONS[name]), atol=1.0)
    assert read_epc(ASSETS / "emotions" / f"{name}.epc").names == (name,)


def test_intensities_scale_and_units_add() -> None:
    units = load_action_units()
    np.testing.assert_allclose(
        combine_action_units({12: 0.5, 26: 1.0}), 0.5 * units[12] + units[26], rtol=1e-5, atol=1e-4
    )
    assert not combine_action_units({}).any()
    left = combine_action_units({12: (1.0, 0.0)})
    assert left[CONTROL_POINT_INDEX["outer_lip_corner_l"], 1] == units[12][CONTROL_POINT_INDEX["outer_lip_corner_l"], 1]
    assert left[CONTROL_POINT_INDEX["outer_lip_corner_r"], 1] == 0
    np.testing.assert_allclose(left + combine_action_units({12: (0.0, 1.0)}), units[12], rtol=1e-5, atol=1e-4)


def test_an_unknown_unit_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"got \[99\]"):
        combine_action_units({99: 1.0})


def test_a_label_has_number_and_name() -> None:
    assert action_unit_label(10) == "AU 10 upper lip raiser"
    assert len(ACTION_UNIT_NAMES) == 16


def test_an_expression_is_loaded_by_name_or_from_a_file() -> None:
    np.testing.assert_array_equal(load_expression("joy")["joy"], load_emotions()["joy"])
    assert load_expression(str(ASSETS / "emotions" / "fear.epc")).names == ("fear",)
    with pytest.raises(ConfError, match=r"no emotion 'bliss': choose one of joy, .*, or give an \.epc file"):
        load_expression("bliss")
    with pytest.raises(FileFormatError, match="check the name"):
        load_expression("bliss.epc")
