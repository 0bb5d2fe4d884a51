from collections.abc import Set
from itertools import pairwise

import pytest

from conf.transport.link_policy import OPEN_TIMEOUTS_S, SILENT_DATAGRAMS, UNHEARD_S, LinkPolicy, SilenceDetector

BOTH, TCP, UDP, NONE = frozenset({"udp", "tcp"}), frozenset({"tcp"}), frozenset({"udp"}), frozenset[str]()


def opened(kinds: Set[str], now: float = 0.0) -> LinkPolicy:
    policy = LinkPolicy()
    policy.on_opened(kinds, now)
    return policy


def test_the_first_session_is_opened_at_once() -> None:
    assert LinkPolicy().is_due(NONE, 0.0)


@pytest.mark.parametrize("kinds", [BOTH, UDP])
def test_a_whole_session_is_kept(kinds: Set[str]) -> None:
    policy = opened(kinds)
    assert not any(policy.is_due(kinds, float(now)) for now in range(1000))


@pytest.mark.parametrize("left", [NONE, TCP, UDP])
def test_a_link_that_has_gone_opens_a_session_at_once(left: Set[str]) -> None:
    assert opened(BOTH).is_due(left, 10.0)


def test_failures_are_tried_again_within_a_second() -> None:
    policy, now, times = LinkPolicy(), 0.0, []
    while now < 10:
        if policy.is_due(NONE, now):
            times.append(now)
            policy.on_failed(now)
        now += 0.05
    waits = [round(b - a, 2) for a, b in pairwise(times)]
    assert waits[0] == 0.1 and max(waits) < 1.0 and len(times) > 10


def test_attempts_take_longer_after_failures_and_as_long_as_the_last_session_has_needed() -> None:
    policy, timeouts = LinkPolicy(), []
    for now in range(6):
        timeouts.append(policy.open_timeout_s)
        policy.on_failed(float(now))
    assert tuple(timeouts) == (*OPEN_TIMEOUTS_S, OPEN_TIMEOUTS_S[-1], OPEN_TIMEOUTS_S[-1])
    policy = LinkPolicy()
    for now in range(2):
        policy.on_failed(float(now))
    policy.on_opened(BOTH, 2.0)
    assert policy.open_timeout_s == OPEN_TIMEOUTS_S[2]
    assert opened(BOTH).open_timeout_s == OPEN_TIMEOUTS_S[0]


def test_udp_is_tried_again_ever_more_rarely() -> None:
    policy = LinkPolicy()
    times: list[int] = []
    for now in range(400):
        if policy.is_due(TCP if times else NONE, float(now)):
            times.append(now)
            policy.on_opened(TCP, float(now))
    assert times == [0, 5, 20, 65, 185, 305]
    policy.on_opened(BOTH, 400.0)
    assert not policy.is_due(BOTH, 1000.0)


def test_tcp_alone_that_breaks_is_replaced_at_once() -> None:
    assert opened(TCP).is_due(NONE, 0.2)


def test_datagrams_without_an_answer_are_noticed_after_a_second_and_a_half() -> None:
    silence = SilenceDetector()
    for step in range(20):
        silence.on_sent(step * 0.1)
        assert not silence.is_silent(step * 0.1) or step * 0.1 >= 1.5
    assert silence.is_silent(2.0)
    silence.on_received(2.0)
    assert not silence.is_silent(2.0)


def test_few_datagrams_are_no_silence() -> None:
    silence = SilenceDetector()
    for step in range(SILENT_DATAGRAMS - 1):
        silence.on_sent(float(step))
    assert not silence.is_silent(100.0)


def test_the_other_end_that_is_not_there_causes_ever_fewer_sessions() -> None:
    silence = SilenceDetector()
    times: list[float] = []
    for step in range(3000):
        now = step * 0.1
        silence.on_sent(now)
        if silence.is_silent(now):
            times.append(now)
            silence.on_opened(now)
    waits = [round(b - a) for a, b in pairwise(times)]
    assert times[0] == 1.5 and waits[:5] == [5, 10, 20, 40, 60] and set(waits[5:]) == {60}


def test_an_answer_counts_though_datagrams_are_sent_all_the_time() -> None:
    silence = SilenceDetector()
    for step in range(1000):
        silence.on_sent(step * 0.01)
        if step % 100 == 50:
            silence.on_received(step * 0.01)
        assert not silence.is_silent(step * 0.01)


def test_after_an_answer_silence_is_noticed_as_soon_as_at_first() -> None:
    silence = SilenceDetector()
    for now in (0.0, 10.0):
        for step in range(4):
            silence.on_sent(now + step * 0.1)
        assert silence.is_silent(now + 2.0)
        silence.on_opened(now + 2.0)
        silence.on_received(now + 8.0)


def test_an_end_that_is_not_heard_opens_a_session_at_once_and_the_next_ones_later() -> None:
    silence = SilenceDetector()
    times: list[float] = []
    for step in range(200):
        now = step * 0.1
        silence.on_received(now)
        if 30 <= step < 100:
            silence.on_unheard(now)
        if silence.is_silent(now):
            times.append(now)
            silence.on_opened(now)
    assert times == [3.0, 8.0]


def test_that_an_end_was_not_heard_counts_for_a_while() -> None:
    silence = SilenceDetector()
    silence.on_unheard(1.0)
    assert silence.is_silent(1.0 + UNHEARD_S / 2) and not silence.is_silent(1.0 + UNHEARD_S)
