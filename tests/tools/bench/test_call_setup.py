from tools.bench.call_setup import Setup, absolute, summary, table


def test_the_summary_counts_the_runs_within_the_limit_and_those_that_failed() -> None:
    runs = [Setup(0.3, 1.1, 1.2), Setup(0.5, 1.4, 1.6), Setup(0.4, 1.0, None)]
    result = summary(runs, 0.0)
    assert result["connected_s"] == {"median": 0.4, "max": 0.5} and result["both_draw_s"] == {"median": 1.4, "max": 1.6}
    assert (result["within"], result["failed"], result["limit_s"]) == (1, 1, 1.5)
    assert "within 1.5 s: 1 of 3" in table(result) and "1 failed" in table(result)


def test_a_loss_without_a_limit_has_no_verdict() -> None:
    result = summary([Setup(None, None, None)], 0.2)
    assert result["within"] is None and result["both_draw_s"] is None and "within" not in table(result)


def test_times_since_the_start_of_a_command_become_those_of_a_clock() -> None:
    assert absolute("100.5", 2.0) == 102.5 and absolute("100.5", None) is None
