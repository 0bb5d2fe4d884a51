"""A short call of the bench: both ways cost what is promised, and everything arrives."""

import numpy as np
import pytest

from conf.face.fapu import Fapu
from tests.support.synthetic_motion import talking
from tools.bench.tracks import Track
from tools.bench.two_way_call import MAX_KBPS, PROFILE_FPS, measure_cost


def track(name: str, first: int) -> Track:
    frames = talking(round(10 * PROFILE_FPS), first=first)
    return Track(name, frames, np.ones(len(frames)), Fapu(1, 1, 1, 1, 1))


@pytest.mark.slow
@pytest.mark.parametrize("profile", MAX_KBPS)
def test_each_direction_costs_less_than_one_way_with_its_reports(profile: str) -> None:
    found = measure_cost(profile, 0.0, [track("a", 0), track("b", 75)], 8.0, seed=1)
    assert found["missed_references"] == found["rejected"] == 0
    for name in ("a", "b"):
        one_way = found[f"{name}_one_way_kbps"] + found[f"{name}_one_way_reports_kbps"]
        assert 0.5 < found[f"{name}_kbps"] < one_way
