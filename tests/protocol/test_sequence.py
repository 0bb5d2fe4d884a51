from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.sequence import ReceptionLog, unwrap


@given(st.integers(0, 1 << 40), st.integers(-60, 60), st.integers(7, 16))
def test_unwrap_finds_any_number_within_half_a_span(near: int, step: int, bits: int) -> None:
    number = max(near + step, 0)
    assert unwrap(number & ((1 << bits) - 1), bits=bits, expected=near) == number


@given(st.permutations(list(range(40))), st.sets(st.integers(0, 39), max_size=20))
def test_loss_is_what_never_came_whatever_the_order(order: list[int], lost: set[int]) -> None:
    log = ReceptionLog()
    arrived = [n for n in order if n not in lost]
    for number in arrived:
        assert log.add(number)
        assert not log.add(number)
    if arrived:
        assert log.received == len(arrived)
        assert log.lost == max(arrived) - min(arrived) + 1 - len(arrived)
        assert log.duplicates == len(arrived)


def test_memory_stays_bounded() -> None:
    log = ReceptionLog()
    for number in range(20_000):
        log.add(number)
    assert len(log._seen) <= 2 * log.WINDOW + 1
    assert not log.add(20_000 - 2 * log.WINDOW)
