"""The choice of points whose residual is sent."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.protocol.codec.model import load_models
from conf.protocol.codec.point_residuals import (
    BITS_PER_RESIDUAL,
    MIN_RESIDUAL,
    MIN_RESIDUAL_INTRA,
    PointResiduals,
    choose_point_residuals,
)
from conf.protocol.codec.symbol_coder import LIMIT
from tests.support.synthetic_motion import grimace, still

MODEL = load_models()["live"]
_T = MODEL.transform
# A model without components: every displacement is a residual, one FAPU unit is one step.
BARE = replace(
    MODEL,
    transform=replace(
        _T,
        forward_matrix=np.zeros_like(_T.forward_matrix),
        inverse_matrix=np.zeros_like(_T.inverse_matrix),
        residual_steps=np.ones_like(_T.residual_steps),
    ),
)


def moved(points: dict[int, tuple[float, float, float]]) -> NDArray[np.float32]:
    """Return displacements of some points, the others at rest."""
    displacements = np.zeros((50, 3), np.float32)
    for point, offset in points.items():
        displacements[point] = offset
    return displacements


def choose(
    points: dict[int, tuple[float, float, float]], known: PointResiduals | None = None, bits_spent: float = 0
) -> list[tuple[int, tuple[int, int, int]]]:
    """Return the chosen residuals in their order."""
    chosen = choose_point_residuals(BARE, moved(points), known or {}, threshold=2.5, bits_spent=bits_spent)
    return list(chosen.items())


def test_usual_motion_has_no_residuals() -> None:
    [frame] = still(1)
    assert choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=0) == {}


def test_thresholds_are_those_of_the_encoder() -> None:
    assert (MIN_RESIDUAL, MIN_RESIDUAL_INTRA, BITS_PER_RESIDUAL, MODEL.profile.target_bits) == (2.5, 4.0, 18, 64)


def test_only_an_error_above_the_threshold_is_sent() -> None:
    assert choose({3: (2.5, 0, 0)}) == []
    assert choose({3: (2.6, 0, 0), 4: (0, 2.5, 0)}) == [(3, (3, 0, 0))]
    assert choose({3: (1.5, 1.5, -1.6)}) == [(3, (2, 2, -2))], "the error is the Euclidean length"


def test_the_largest_error_comes_first_and_equal_ones_in_order_of_points() -> None:
    assert [point for point, _ in choose({9: (4, 0, 0), 2: (0, 0, -5), 7: (0, 4, 0)})] == [2, 7, 9]


@pytest.mark.parametrize(
    ("bits_spent", "count"), [(64 - 54, 3), (64 - 53, 2), (64 - 36, 2), (64 - 35, 1), (64, 1), (1000, 1), (-1000, 12)]
)
def test_the_bit_budget_limits_the_number(bits_spent: float, count: int) -> None:
    points = {point: (9.0, 0.0, 0.0) for point in range(20)}
    assert len(choose(points, bits_spent=bits_spent)) == count


def test_the_error_is_what_the_known_residuals_leave() -> None:
    assert choose({3: (9, 0, 0)}, known={3: (9, 0, 0)}) == []
    assert choose({3: (9, 0, 0)}, known={3: (4, 0, 0)}) == [(3, (9, 0, 0))]
    assert choose({}, known={3: (40, 0, 0)}) == [(3, (0, 0, 0))], "an obsolete residual is removed"


def test_residuals_are_clipped() -> None:
    assert choose({3: (1e6, -1e6, 0)}) == [(3, (LIMIT, -LIMIT, 0))]


def test_a_grimace_sends_the_points_that_were_moved() -> None:
    [frame] = grimace(1)
    chosen = choose_point_residuals(MODEL, frame.displacements, {}, threshold=MIN_RESIDUAL, bits_spent=0)
    assert len(chosen) == 3
    assert next(iter(chosen)) in {
        CONTROL_POINT_INDEX["nose_bottom_edge_l"],
        CONTROL_POINT_INDEX["brow_outer_l"],
        CONTROL_POINT_INDEX["inner_lip_upper_mid"],
    }
    more = choose_point_residuals(MODEL, frame.displacements, chosen, threshold=MIN_RESIDUAL, bits_spent=0)
    assert not set(chosen) & set(more)
