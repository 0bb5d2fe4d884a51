from typing import Any

import pytest

from tools.bench.portrait_start import SECONDS, figures, motion_delays, start_times


def test_times_run_from_the_start_of_the_call() -> None:
    sent: list[dict[str, Any]] = [{"began": 10.0, "frames": [(10.6, 0.0)]}, {"began": 10.0, "frames": []}]
    received: list[dict[str, Any]] = [{"portraits": {}}, {"portraits": {"7": 14.25}}, {"portraits": {"7": 14.25}}]
    assert start_times(sent, received) == {"connected_s": 0.6, "shown_s": 4.25}


def test_a_portrait_that_is_never_shown_counts_as_the_whole_call() -> None:
    sent = [{"began": 0.0, "frames": [(0.5, 0.0)]}]
    never = start_times(sent, [{"portraits": {}}]) | {"added_ms_worst": 7}
    result = figures([never, never, {"connected_s": 0.5, "shown_s": 4.0, "added_ms_worst": 5}])
    assert never["shown_s"] is None and result["worst_s"] == result["median_s"] == SECONDS


def test_motion_is_delayed_by_the_queue_and_by_the_portrait_in_its_datagram() -> None:
    lines = [{"datagrams": [(0.0, 50, 0), (0.01, 130, 130), (0.02, 60, 0)]}, {"datagrams": [(1.0, 140, 90)]}]
    delays, added = motion_delays(lines, 16)
    assert delays == pytest.approx([0.025, 0.1, 0.07])
    assert added == pytest.approx([0, 0.065, 0.045])
