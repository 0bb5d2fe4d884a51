"""Proportions of a person on a head: distances change as asked, and what touches still touches."""

from dataclasses import astuple

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.fapu import Fapu
from conf.face.loading import load_face
from conf.face.proportions import MAX_RATIO, MEAN_DISTANCES, MIN_RATIO, NO_CHANGE, ProportionFields, proportion_ratios
from conf.sender.motion.mean_face import MEAN_FACE

NAMES = ("es0", "ens0", "mns0", "mw0")


@pytest.fixture(scope="module")
def head() -> FaceModel:
    return load_face()


@pytest.fixture(scope="module")
def fields(head: FaceModel) -> ProportionFields:
    return ProportionFields(head)


def test_the_mean_distances_are_those_of_the_mean_face() -> None:
    assert astuple(Fapu.measure(MEAN_FACE))[:4] == pytest.approx(MEAN_DISTANCES, abs=1e-3)
    assert proportion_ratios(astuple(Fapu.measure(MEAN_FACE))) == NO_CHANGE


def test_ratios_are_bounded_and_tiny_differences_nothing() -> None:
    assert proportion_ratios((60.0, 0.1, 2.881 * 1.05, 5.182, 1.0)) == pytest.approx((MAX_RATIO, MIN_RATIO, 1.05, 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [MIN_RATIO, 1.05, MAX_RATIO])
@pytest.mark.parametrize("name", NAMES)
def test_a_ratio_changes_its_distance_on_the_head(
    head: FaceModel, fields: ProportionFields, name: str, ratio: float
) -> None:
    shift = fields.shift(tuple(ratio if n == name else 1.0 for n in NAMES))  # type: ignore[arg-type]
    assert shift is not None
    nearest = [int(np.linalg.norm(head.neutral - point, axis=1).argmin()) for point in head.control_points]
    before, after = Fapu.measure(head.neutral[nearest]), Fapu.measure((head.neutral + shift)[nearest])
    assert getattr(after, name) / getattr(before, name) - 1 == pytest.approx(ratio - 1, rel=0.25)
    for other in {*NAMES} - {name}:
        assert getattr(after, other) / getattr(before, other) == pytest.approx(1.0, abs=0.035), other
    assert after.irisd0 == pytest.approx(before.irisd0, rel=0.03), "lids keep their distance"


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [MIN_RATIO, MAX_RATIO])
def test_lips_stay_closed_eyeballs_round_and_shoulders_still(
    head: FaceModel, fields: ProportionFields, ratio: float
) -> None:
    shift = fields.shift((ratio, ratio, ratio, ratio))
    assert shift is not None
    for eye in head.rig.eyes if head.rig else ():
        assert np.ptp(shift[eye.vertices], axis=0) == pytest.approx(0.0, abs=1e-6)
        assert np.abs(shift[eye.lids] - shift[eye.vertices[0]]).max() < 0.09, "lids move as their eyeball"
    for side in ("mid", "l", "r"):
        pair = (CONTROL_POINT_INDEX[f"inner_lip_{lip}_{side}"] for lip in ("upper", "lower"))
        upper, lower = (int(np.linalg.norm(head.neutral - head.control_points[i], axis=1).argmin()) for i in pair)
        assert np.abs(shift[upper] - shift[lower]).max() < 0.02
    assert np.abs(shift[head.mesh.group_vertices("shirt")]).max() < 0.02


@pytest.mark.slow
def test_displacements_are_scaled_with_their_distances(head: FaceModel, fields: ProportionFields) -> None:
    motion = np.zeros((50, 3), np.float32)
    motion[CONTROL_POINT_INDEX["chin_bottom"], 1] = -300
    ratios = (1.0, 1.0, MAX_RATIO, 1.0)
    shift = fields.shift(ratios)
    moved = fields.deform(motion, ratios, shift) - fields.deform(None, ratios, shift)
    plain = fields.deform(motion, NO_CHANGE, None) - fields.deform(None, NO_CHANGE, None)
    assert moved.min() / plain.min() == pytest.approx(MAX_RATIO, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("long", [0.85, 1.0, 1.2])
def test_a_mouth_opens_as_far_as_the_persons_whatever_the_head_takes_on(
    head: FaceModel, fields: ProportionFields, long: float
) -> None:
    person = Fapu.measure(MEAN_FACE)
    person = Fapu(person.es0, person.ens0, person.mns0 * long, person.mw0, person.irisd0)
    displacements = np.zeros((50, 3), np.float32)
    displacements[LOWER_LIP, 1] = -1.0 / person.lengths()[LOWER_LIP, 1]  # by 1 cm
    lips, openings = LipOpening(head), []
    for ratios in (NO_CHANGE, proportion_ratios(person.distances)):
        shift = fields.shift(ratios)
        moved = fields.deform(displacements, ratios, shift, sender=person)
        openings.append(lips.measure(moved if shift is None else moved - shift))
    assert openings[0] == pytest.approx(openings[1], abs=0.01)
    assert openings[0] == pytest.approx(1.02, abs=0.06)  # its eyes are farther apart than the mean face's
