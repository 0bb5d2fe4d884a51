"""The bucket's one promise: in any T seconds no more than rate T + capacity."""

from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.rate_limit import TokenBucket

ASKS = st.lists(st.tuples(st.floats(0, 3), st.integers(1, 30)), max_size=60)


@given(ASKS, st.floats(0.1, 100), st.floats(1, 100))
def test_no_stretch_of_time_gets_more_than_it_may(asks: list[tuple[float, int]], rate: float, capacity: float) -> None:
    bucket, now, taken = TokenBucket(rate, capacity), 0.0, list[tuple[float, int]]()
    for step, amount in asks:
        now += step
        if bucket.take(amount, now):
            taken.append((now, amount))
        for start, _ in taken:
            total = sum(amount for time, amount in taken if start <= time <= now)
            assert total <= rate * (now - start) + capacity + 1e-6


@given(ASKS, st.floats(0.1, 100))
def test_wait_is_just_long_enough(asks: list[tuple[float, int]], rate: float) -> None:
    bucket, now = TokenBucket(rate, 30), 0.0
    for step, amount in asks:
        now += step
        wait = bucket.time_until(amount, now)
        if wait > 1e-3:
            assert not bucket.take(amount, now + wait * 0.99)
        now += wait * 1.01 + 1e-6
        assert bucket.take(amount, now)


def test_more_than_the_capacity_never_comes() -> None:
    assert TokenBucket(1, 10).time_until(11, 0.0) == float("inf")
    assert TokenBucket(0, 10).time_until(10, 0.0) == 0.0


def test_a_clock_that_goes_back_gives_nothing() -> None:
    bucket = TokenBucket(10, 10)
    assert bucket.take(10, 100.0)
    assert not bucket.take(1, 50.0)
