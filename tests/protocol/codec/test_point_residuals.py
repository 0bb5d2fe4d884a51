"""Which points are sent one by one."""

import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.protocol.codec.model import load_models
from conf.protocol.codec.point_residuals import MIN_RESIDUAL, choose_point_residuals
from conf.protocol.codec.syntax import MAX_RESIDUALS
from tests.support.synthetic_motion import grimace, still

MODEL = load_models()["live"]


def test_a_usual_face_needs_none() -> None:
    [frame] = still(1)
    assert choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=0) == {}


def test_the_worst_point_comes_first_and_room_is_kept() -> None:
    [frame] = grimace(1)
    many = choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=0)
    one = choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=1000)
    sizes = [np.linalg.norm(steps) for steps in many.values()]
    assert sizes == sorted(sizes, reverse=True)
    assert 1 < len(many) <= MAX_RESIDUALS
    assert list(one) == list(many)[:1]
    assert next(iter(many)) in {
        CONTROL_POINT_INDEX["nose_bottom_edge_l"],
        CONTROL_POINT_INDEX["brow_outer_l"],
        CONTROL_POINT_INDEX["inner_lip_upper_mid"],
    }


def test_what_is_known_is_not_sent_again() -> None:
    [frame] = grimace(1)
    known = choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=0)
    more = choose_point_residuals(MODEL, frame.displacements, known, threshold=MIN_RESIDUAL, bits_spent=0)
    assert not set(known) & set(more)


def test_when_the_grimace_ends_its_corrections_are_undone() -> None:
    [frame] = still(1)
    assert choose_point_residuals(
        MODEL, frame.displacements, {3: (40, 0, 0)}, threshold=MIN_RESIDUAL, bits_spent=0
    ) == {3: (0, 0, 0)}
