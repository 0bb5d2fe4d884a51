import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.varints import decode_numbers, encode_numbers


@given(st.lists(st.integers(-(2**19), 2**19)))
def test_numbers_survive(numbers: list[int]) -> None:
    np.testing.assert_array_equal(decode_numbers(encode_numbers(numbers), len(numbers)), numbers)


def test_small_numbers_take_a_byte() -> None:
    assert encode_numbers([0, -1, 1, 63, -64]).hex() == "0001027e7f"


@pytest.mark.parametrize("data", ["80", "0000", "80808001", ""])
def test_other_counts_and_endless_numbers_are_refused(data: str) -> None:
    with pytest.raises(ProtocolError):
        decode_numbers(bytes.fromhex(data), 1)


@given(st.binary(max_size=60), st.integers(0, 20))
def test_any_bytes_are_numbers_or_the_one_error(data: bytes, count: int) -> None:
    try:
        assert len(decode_numbers(data, count)) == count
    except ProtocolError:
        pass
