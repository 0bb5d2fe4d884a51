"""In any T seconds a bucket gives at most rate T + capacity, a limiter in ten seconds at most its kbit/s."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.rate_control.rate_limit import RateLimiter, TokenBucket

REQUESTS = st.lists(st.tuples(st.floats(0, 3), st.integers(1, 30)), max_size=60)


@pytest.mark.slow
@given(REQUESTS, st.floats(0.1, 100), st.floats(1, 100))
def test_no_period_gets_more_than_rate_and_capacity(
    requests: list[tuple[float, int]], rate: float, capacity: float
) -> None:
    bucket, now, taken = TokenBucket(rate, capacity), 0.0, list[tuple[float, int]]()
    for step, amount in requests:
        now += step
        if bucket.consume(amount, now):
            taken.append((now, amount))
        for start, _ in taken:
            total = sum(amount for time, amount in taken if start <= time <= now)
            assert total <= rate * (now - start) + capacity + 1e-6


@pytest.mark.slow
@given(REQUESTS, st.floats(0.1, 100))
def test_time_until_is_just_long_enough(requests: list[tuple[float, int]], rate: float) -> None:
    bucket, now = TokenBucket(rate, 30), 0.0
    for step, amount in requests:
        now += step
        wait = bucket.time_until(amount, now)
        if wait > 1e-3:
            assert not bucket.consume(amount, now + wait * 0.99)
        now += wait * 1.01 + 1e-6
        assert bucket.consume(amount, now)


def test_a_bucket_step_by_step() -> None:
    bucket = TokenBucket(2, 10)
    assert bucket.consume(10, 100.0) and not bucket.consume(1, 100.0)
    assert bucket.time_until(3, 100.0) == 1.5
    assert not bucket.consume(3, 101.0) and bucket.consume(3, 101.5)
    assert bucket.time_until(10, 200.0) == 0.0
    assert bucket.consume(10, 200.0) and not bucket.consume(1, 200.0), "a pause fills no more than the capacity"


def test_more_than_the_capacity_never_comes() -> None:
    assert TokenBucket(1, 10).time_until(11, 0.0) == float("inf")
    assert TokenBucket(1, 10).time_until(10, 0.0) == 0.0
    assert TokenBucket(0, 10).time_until(10, 0.0) == 0.0
    empty = TokenBucket(0, 10)
    assert empty.consume(10, 0.0) and empty.time_until(1, 0.0) == float("inf")


def test_a_forced_amount_becomes_a_debt_of_at_most_the_capacity() -> None:
    bucket = TokenBucket(2, 10)
    bucket.force_take(4, 0.0)
    assert bucket.time_until(10, 0.0) == 2.0
    bucket.force_take(8, 0.0)
    assert bucket.time_until(10, 0.0) == 6.0
    bucket.force_take(1000, 0.0)
    assert bucket.time_until(10, 0.0) == 10.0
    bucket.force_take(0, 3.0)
    assert bucket.time_until(10, 3.0) == 7.0
    bucket.force_take(4, 100.0)
    assert bucket.time_until(10, 100.0) == 2.0


def test_a_bucket_can_owe_more_than_it_holds() -> None:
    bucket = TokenBucket(2, 10, max_debt=40)
    bucket.force_take(30, 0.0)
    assert bucket.debt(0.0) == 20 and bucket.time_until(10, 0.0) == 15.0
    bucket.force_take(1000, 0.0)
    assert bucket.debt(0.0) == 40 and bucket.debt(15.0) == 10 and bucket.debt(30.0) == 0


def test_a_clock_that_goes_back_gives_nothing() -> None:
    bucket = TokenBucket(10, 10)
    assert bucket.consume(10, 100.0)
    assert not bucket.consume(1, 50.0)


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 2), st.integers(42, 180)), max_size=80), st.sampled_from([2.4, 5.8, 16.0]))
def test_the_limit_holds_over_any_ten_seconds(requests: list[tuple[float, int]], kbps: float) -> None:
    limiter, now, sent = RateLimiter(kbps), 0.0, list[tuple[float, int]]()
    for step, size in requests:
        now += step
        if limiter.consume(size, now):
            sent.append((now, size))
        assert sum(size for time, size in sent if time > now - 10) * 8 <= kbps * 10_000 + 1e-6


def test_a_sender_that_always_asks_gets_nearly_all_of_the_limit() -> None:
    limiter = RateLimiter(5.8)
    total = sum(48 * limiter.consume(48, step / 100) for step in range(10_000))
    assert 0.93 * 5.8 < total * 8 / 1000 / 100 <= 5.8


@pytest.mark.parametrize(("kbps", "max_bytes"), [(16.0, 1250.0), (1.0, 96.0), (0.064, 80.0)])
def test_the_burst_is_a_sixteenth_of_ten_seconds_but_lets_a_handshake_pass(kbps: float, max_bytes: float) -> None:
    assert RateLimiter(kbps).max_bytes == pytest.approx(max_bytes)
    assert RateLimiter(kbps).consume(int(max_bytes), 0.0)
    assert not RateLimiter(kbps).consume(int(max_bytes) + 1, 0.0)


def test_headroom_leaves_half_of_the_burst() -> None:
    limiter = RateLimiter(16.0)
    assert limiter.has_headroom(625, 0.0) and not limiter.has_headroom(626, 0.0)
    assert limiter.consume(500, 0.0)
    assert limiter.has_headroom(125, 0.0) and not limiter.has_headroom(126, 0.0)


@pytest.mark.parametrize("kbps", [0, -1, float("nan")])
def test_a_limit_must_be_above_0(kbps: float) -> None:
    with pytest.raises(ValueError, match="kbps must be above 0"):
        RateLimiter(kbps)


def test_a_steady_stream_may_use_the_limit_completely() -> None:
    limiter = RateLimiter(2.4)  # 3,000 B in ten seconds
    stamps = [0.48 * step for step in range(200)]
    assert all(limiter.consume_steady(142, now) for now in stamps), "21 datagrams in any ten seconds"
    limiter = RateLimiter(2.4)
    assert [limiter.consume_steady(143, now) for now in stamps].count(False) > 5


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.floats(0, 1), st.integers(42, 400), st.booleans()), max_size=80),
    st.sampled_from([2.4, 6.0, 16.0]),
)
def test_the_limit_holds_whatever_part_is_steady(requests: list[tuple[float, int, bool]], kbps: float) -> None:
    limiter, now, sent = RateLimiter(kbps), 0.0, list[tuple[float, int]]()
    for step, size, is_steady in requests:
        now += step
        if (limiter.consume_steady if is_steady else limiter.consume)(size, now):
            sent.append((now, size))
        assert sum(size for time, size in sent if now < time + 10) * 8 <= kbps * 10_000 + 1e-6


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.integers(0, 200), st.booleans()), min_size=1, max_size=60),
    st.sampled_from([(2.4, 117, 0.48), (6.0, 130, 0.2), (16.0, 113, 0.06)]),
)
def test_what_keeps_to_the_room_never_costs_a_datagram_of_the_stream(
    extras: list[tuple[int, bool]], stream: tuple[float, int, float]
) -> None:
    kbps, size, interval_s = stream
    limiter, now = RateLimiter(kbps), 0.0
    for extra, takes_all in extras * 4:
        room = limiter.room(size, interval_s, now) - size
        more = min(extra, max(0, int(room))) if not takes_all else max(0, int(room))
        assert limiter.consume_steady(size + more, now)
        now += interval_s - (more % 2) * 0.001


def test_room_is_what_the_stream_of_ten_seconds_leaves() -> None:
    limiter = RateLimiter(1.0)  # 1,250 B in ten seconds
    assert limiter.room(100, 1.0, 0.0) == 1250 - 10 * 100, "the tenth may come a little early"
    assert limiter.room(100, 1.02, 0.0) == 1250 - 9 * 100
    assert limiter.consume_steady(300, 0.0)
    assert limiter.room(100, 1.0, 1.0) == 1250 - 300 - 9 * 100
    assert limiter.room(100, 1.0, 9.0) == 1250 - 10 * 100, (
        "when the first comes, the 300 still count, when the second does, no more"
    )
    assert limiter.room(0, 100.0, 9.999) == 1250 - 300 and limiter.room(0, 100.0, 10.0) == 1250
    assert limiter.room(200, 1.0, 20.0) < 0
