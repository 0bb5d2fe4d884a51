import pytest

from tools.network.relay_delay import EndDelays, summarize


def test_the_delay_that_a_relay_adds_is_that_of_the_95th_percentile() -> None:
    hundred = [number / 1000 for number in range(100)]
    slower = [delay + 0.004 for delay in hundred]
    found = summarize([EndDelays(100, slower, hundred), EndDelays(100, slower, hundred[::-1])])
    assert found.added_p95_ms == pytest.approx(4) and found.reaches
    assert (found.direct_p95_ms, found.relay_p50_ms) == (pytest.approx(95), pytest.approx(53.5))
    assert found.relay_loss == found.direct_loss == 0


def test_losses_are_counted_and_a_slow_relay_misses() -> None:
    found = summarize([EndDelays(100, [0.05] * 90, [0.001] * 100), EndDelays(100, [0.05] * 90, [0.001] * 100)])
    assert found.relay_loss == pytest.approx(0.1) and not found.reaches
