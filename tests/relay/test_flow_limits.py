from hypothesis import given
from hypothesis import strategies as st

from conf.relay.flow_limits import (
    DATAGRAM_COST,
    MAX_PENDING,
    MAX_PENDING_PER_HOST,
    MIN_PER_HOST,
    PENDING_S,
    SENT_AT_ONCE,
    SENT_PER_S,
    Admission,
    FlowLimit,
    host_key,
    sending_limit,
)


def test_a_call_with_voice_and_portrait_passes_and_a_flood_does_not() -> None:
    limit = sending_limit()
    for number in range(2000):  # 100 datagrams of 300 B a second: 240 kbit/s
        assert limit.admits(300, number / 100)
    flood = [limit.admits(50, 20 + number / 50_000) for number in range(50_000)]
    assert sum(flood) <= (SENT_PER_S + SENT_AT_ONCE) / (50 + DATAGRAM_COST) + 1


@given(st.lists(st.tuples(st.integers(0, 65_535), st.floats(0, 0.2)), max_size=100))
def test_no_more_than_the_limit_passes(datagrams: list[tuple[int, float]]) -> None:
    limit, now, passed = FlowLimit(1000.0, 5000.0), 0.0, 0
    for size, gap in datagrams:
        now += gap
        passed += size * limit.admits(size, now)
    assert passed <= 5000 + 1000 * now + 1e-6


def test_a_stream_above_its_limit_has_to_wait() -> None:
    limit = FlowLimit(1000.0, 5000.0)
    assert limit.delay_after(5000, 0.0) == 0
    assert limit.delay_after(500, 0.0) == 0.5
    assert limit.delay_after(0, 0.5) == 0


def test_flows_are_limited_in_all_and_of_one_host() -> None:
    admission = Admission[int](4 * MIN_PER_HOST)
    for number in range(MIN_PER_HOST):
        assert admission.has_room("192.0.2.1")
        admission.open(number, "192.0.2.1", 0.0)
        admission.accept(number)
    assert not admission.has_room("192.0.2.1") and admission.has_room("192.0.2.2")
    assert admission.refused == 1
    admission.close(0, "192.0.2.1")
    assert admission.has_room("192.0.2.1")
    for number in range(100, 100 + 3 * MIN_PER_HOST + 1):
        admission.open(number, f"198.51.100.{number}", 0.0)
        admission.accept(number)
    assert not admission.has_room("192.0.2.2")


def test_the_oldest_pending_flow_is_evicted_and_one_host_has_few() -> None:
    admission = Admission[int](1000)
    for number in range(MAX_PENDING):
        assert admission.open(number, f"host{number // MAX_PENDING_PER_HOST}", 1.0) is None
    assert not admission.has_room("host0")
    assert admission.open(-1, "other", 2.0) == 0
    admission.close(0, "host0")
    assert admission.has_room("host0")
    assert admission.late(1.0 + PENDING_S) == []
    assert admission.late(1.1 + PENDING_S) == list(range(1, MAX_PENDING))
    admission.accept(1)
    admission.accept(1)
    assert 1 not in admission.late(100.0)


def test_an_ipv6_network_is_one_host() -> None:
    assert host_key("2001:db8::1") == host_key("2001:db8::ffff:2%eth0") != host_key("2001:db8:0:1::1")
    assert host_key("192.0.2.1") != host_key("192.0.2.2")
