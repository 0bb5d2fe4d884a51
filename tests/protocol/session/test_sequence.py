import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.sequence import unwrap


@pytest.mark.slow
@given(st.integers(0, 1 << 40), st.integers(-60, 60), st.integers(7, 16))
def test_any_number_within_half_a_span_is_restored(expected: int, step: int, bits: int) -> None:
    number = max(expected + step, 0)
    restored = unwrap(number & ((1 << bits) - 1), bits=bits, expected=expected)
    assert restored == number and type(restored) is int


@pytest.mark.parametrize(
    ("low", "expected", "number"),
    [
        (0, 0, 0),
        (127, 0, 127),  # -1 is nearer, but numbers start at 0
        (64, 0, 64),
        (65, 0, 65),
        (0, 64, 128),  # a tie goes up
        (0, 63, 0),
        (63, 127, 191),
        (62, 127, 190),
        (64, 127, 64),
        (5, 1000, 1029),
        (127, 1000, 1023),
    ],
)
def test_seven_bits_near_the_ends_of_a_span(low: int, expected: int, number: int) -> None:
    assert unwrap(low, bits=7, expected=expected) == number
