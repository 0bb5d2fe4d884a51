import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu, governing, motion_scales
from tests.support.sheet_face import SheetFace


def test_the_five_distances_are_measured(face: SheetFace) -> None:
    fapu = Fapu.measure(face.points)
    assert fapu.es0 == pytest.approx(6.4)
    assert fapu.mw0 == pytest.approx(5.0)
    assert fapu.irisd0 == pytest.approx(0.7, abs=0.01)
    assert 4 < fapu.ens0 < 5
    assert 2 < fapu.mns0 < 3


def test_units_scale_with_the_face(face: SheetFace) -> None:
    small, large = Fapu.measure(face.points), Fapu.measure(face.points * 2.5)
    assert large.lengths() == pytest.approx(small.lengths() * 2.5)


def test_each_axis_uses_its_governing_distance() -> None:
    lengths = Fapu(es0=1, ens0=2, mns0=3, mw0=4, irisd0=5).lengths() * UNITS_PER_DISTANCE
    assert lengths.shape == (CONTROL_POINT_COUNT, 3)
    for name, axes in {
        "inner_lip_corner_l": (4, 3, 4),
        "chin_bottom": (4, 3, 4),
        "eyelid_upper_r": (1, 5, 1),
        "pupil_l": (1, 1, 1),
        "brow_inner_r": (2, 2, 2),
        "cheek_center_l": (2, 2, 2),
        "nostril_border_l": (2, 2, 2),
        "eye_upper_outer_lid_l": (1, 1, 1),
    }.items():
        assert lengths[CONTROL_POINT_INDEX[name]] == pytest.approx(axes), name


def test_the_gap_of_a_closed_eye_is_subtracted(face: SheetFace) -> None:
    open_gap = Fapu.measure(face.points).irisd0
    assert Fapu.measure(face.points, closed_lid_gap=0.25).irisd0 == pytest.approx(0.75 * open_gap)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_a_distance_must_be_positive(bad: float) -> None:
    with pytest.raises(ValueError, match="every FAPU distance must be positive"):
        Fapu(es0=bad, ens0=1, mns0=1, mw0=1, irisd0=1)


def test_a_face_moves_each_part_as_far_as_the_sender_relative_to_its_eye_width() -> None:
    face = Fapu(es0=6.4, ens0=4.8, mns0=2.6, mw0=5.0, irisd0=1.0)
    person = Fapu(es0=10.0, ens0=8.0, mns0=4.5, mw0=8.0, irisd0=1.5)
    scales = np.array(motion_scales(person, face, 9.0))
    moved = scales * face.distances / 9.0  # by displacements of 1024 units, in eye widths
    assert moved == pytest.approx(np.divide(person.distances, 13.9))
    assert motion_scales(person, Fapu(*np.multiply(face.distances, 2.0)), 18.0) == pytest.approx(scales)


def test_scales_of_motion_are_limited() -> None:
    face = Fapu(es0=6.4, ens0=4.8, mns0=2.6, mw0=5.0, irisd0=1.0)
    tiny = Fapu(es0=6.4, ens0=0.1, mns0=0.1, mw0=0.1, irisd0=0.1)
    huge = Fapu(es0=0.1, ens0=4.8, mns0=2.6, mw0=5.0, irisd0=1.0)
    assert motion_scales(tiny, face, 8.896) == pytest.approx((1.0, 0.625, 0.625, 0.625, 0.75))
    assert motion_scales(huge, face, 8.896) == pytest.approx((1.0, 1.6, 1.6, 1.6, 1.15))


def test_each_axis_has_the_value_that_governs_it() -> None:
    values = governing((1.0, 2.0, 3.0, 4.0, 5.0))
    assert values[CONTROL_POINT_INDEX["eyelid_lower_l"]].tolist() == [1.0, 5.0, 1.0]
    assert values[CONTROL_POINT_INDEX["outer_lip_upper_mid"]].tolist() == [4.0, 3.0, 4.0]
