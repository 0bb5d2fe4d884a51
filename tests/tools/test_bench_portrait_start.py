from tools.bench_portrait_start import SECONDS, figures, started


def test_it_counts_from_the_first_call_to_the_first_portrait() -> None:
    sent = [{"began": 10.0, "frames": [(10.6, 0.0)]}, {"began": 10.0, "frames": []}]
    received = [{"portraits": {}}, {"portraits": {"7": 14.25}}, {"portraits": {"7": 14.25}}]
    assert started(sent, received) == {"connected_s": 0.6, "shown_s": 4.25}


def test_a_portrait_that_never_comes_counts_as_a_whole_call() -> None:
    sent = [{"began": 0.0, "frames": [(0.5, 0.0)]}]
    never = started(sent, [{"portraits": {}}])
    result = figures([never, never, {"connected_s": 0.5, "shown_s": 4.0}])
    assert never["shown_s"] is None and result["worst_s"] == result["median_s"] == SECONDS
