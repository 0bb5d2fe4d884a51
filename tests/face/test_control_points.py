from pathlib import Path

import numpy as np

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    CONTROL_POINT_LANDMARKS,
    CONTROL_POINTS,
    LOWER_LID,
    LOWER_LIP,
    PUPILS,
    UPPER_LID,
    UPPER_LIP,
    control_point_indices,
)


def test_fifty_points_have_distinct_names_numbers_and_landmarks() -> None:
    assert CONTROL_POINT_COUNT == 50
    assert [point.index for point in CONTROL_POINTS] == list(range(50))
    for column in ("name", "feature_point", "landmark"):
        assert len({getattr(point, column) for point in CONTROL_POINTS}) == 50
    assert CONTROL_POINT_LANDMARKS.max() < 478


def test_the_table_equals_the_designs(shared: Path) -> None:
    rows = (shared / "control_points.csv").read_text().splitlines()[1:]
    ours = [f"{p.index},{p.feature_point},{p.name},{p.landmark}" for p in CONTROL_POINTS]
    assert ours == [row.strip() for row in rows]


def test_left_and_right_points_are_paired() -> None:
    for name in CONTROL_POINT_INDEX:
        if name.endswith("_l"):
            assert name[:-1] + "r" in CONTROL_POINT_INDEX


def test_lip_and_lid_groups_are_disjoint() -> None:
    groups = [UPPER_LIP, LOWER_LIP, UPPER_LID, LOWER_LID, PUPILS]
    assert [len(group) for group in groups] == [8, 6, 4, 4, 2]
    assert len(np.unique(np.concatenate(groups))) == sum(map(len, groups))


def test_indices_are_selected_by_prefix() -> None:
    assert control_point_indices("pupil") == [CONTROL_POINT_INDEX["pupil_l"], CONTROL_POINT_INDEX["pupil_r"]]
    assert control_point_indices("nobody") == []
