from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S, CircuitBreaker


def test_it_opens_ten_seconds_after_the_last_report_probes_and_closes_again() -> None:
    breaker = CircuitBreaker(0.0)
    assert not breaker.is_open(OPEN_AFTER_S - 0.1)
    assert not breaker.consume_probe(OPEN_AFTER_S - 0.1)
    assert breaker.is_open(OPEN_AFTER_S)
    probes = [t / 10 for t in range(100, 500) if breaker.consume_probe(t / 10)]
    assert probes == [10.0, 11.0, 13.0, 17.0, 25.0, 33.0, 41.0, 49.0]
    breaker.on_report(50.0)
    assert not breaker.is_open(50.0)
    assert [t / 10 for t in range(500, 630) if breaker.consume_probe(t / 10)] == [60.0, 61.0]


def test_the_clock_starts_when_it_is_made() -> None:
    breaker = CircuitBreaker(500.0)
    assert not breaker.is_open(509.9)
    assert breaker.is_open(510.0) and breaker.consume_probe(510.0)
