"""Cookies are bound to address, content and time. Wrong codes are counted over a sliding minute."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.flood_protection import (
    COOKIE_SLOT_S,
    MAX_WRONG_CODES,
    RELAY_CODES_PERIOD_S,
    WRONG_CODES_PERIOD_S,
    AttemptLimit,
    CookieFactory,
)
from tests.support.simulated_sessions import SENDER, seeded


def test_a_cookie_is_valid_for_its_address_content_and_time_only() -> None:
    factory = CookieFactory(seeded(1))
    cookie = factory.make(b"bound", SENDER, 100.0)
    assert factory.check(cookie, b"bound", SENDER, 100.0 + COOKIE_SLOT_S)
    assert not factory.check(cookie, b"bound", SENDER, 100.0 + 2 * COOKIE_SLOT_S)
    assert not factory.check(cookie, b"bounD", SENDER, 100.0)
    assert not factory.check(cookie, b"bound", ("198.51.100.7", 40001), 100.0)
    assert not factory.check(cookie, b"bound", ("198.51.100.8", 40000), 100.0)
    assert not CookieFactory(seeded(2)).check(cookie, b"bound", SENDER, 100.0)


@pytest.mark.slow
@given(st.lists(st.floats(0, 50), max_size=60))
def test_no_minute_has_more_than_five_wrong_codes(steps: list[float]) -> None:
    limit, now, tried = AttemptLimit(), 0.0, list[float]()
    for step in steps:
        now += step
        assert (limit.wait(now) > 0) == (limit.tries_left(now) == 0)
        if not limit.wait(now):
            limit.record(now)
            tried.append(now)
        assert sum(now - time < WRONG_CODES_PERIOD_S for time in tried) <= MAX_WRONG_CODES


def test_the_wait_ends_when_the_oldest_is_a_minute_old() -> None:
    limit = AttemptLimit()
    for now in range(MAX_WRONG_CODES):
        assert limit.tries_left(float(now)) == MAX_WRONG_CODES - now
        limit.record(float(now))
    assert limit.wait(10.0) == 50.0
    assert limit.wait(60.0) == 0.0
    assert limit.tries_left(60.0) == 1


def test_a_longer_period_allows_fewer_guesses() -> None:
    limit = AttemptLimit(RELAY_CODES_PERIOD_S)
    for _ in range(MAX_WRONG_CODES):
        limit.record(0.0)
    assert limit.tries_left(RELAY_CODES_PERIOD_S - 1) == 0 and limit.wait(100.0) == RELAY_CODES_PERIOD_S - 100
    assert limit.tries_left(RELAY_CODES_PERIOD_S) == MAX_WRONG_CODES
