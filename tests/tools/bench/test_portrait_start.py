import pytest

from tools.bench.portrait_start import SECONDS, figures, started, waits


def test_it_counts_from_the_first_call_to_the_first_portrait() -> None:
    sent = [{"began": 10.0, "frames": [(10.6, 0.0)]}, {"began": 10.0, "frames": []}]
    received = [{"portraits": {}}, {"portraits": {"7": 14.25}}, {"portraits": {"7": 14.25}}]
    assert started(sent, received) == {"connected_s": 0.6, "shown_s": 4.25}


def test_a_portrait_that_never_comes_counts_as_a_whole_call() -> None:
    sent = [{"began": 0.0, "frames": [(0.5, 0.0)]}]
    never = started(sent, [{"portraits": {}}]) | {"added_ms_worst": 7}
    result = figures([never, never, {"connected_s": 0.5, "shown_s": 4.0, "added_ms_worst": 5}])
    assert never["shown_s"] is None and result["worst_s"] == result["median_s"] == SECONDS


def test_motion_waits_for_what_is_before_it_and_for_what_it_carries() -> None:
    lines = [{"datagrams": [(0.0, 50, 0), (0.01, 130, 130), (0.02, 60, 0)]}, {"datagrams": [(1.0, 140, 90)]}]
    through, added = waits(lines, 16)
    assert through == pytest.approx([0.025, 0.1, 0.07])
    assert added == pytest.approx([0, 0.065, 0.045])
