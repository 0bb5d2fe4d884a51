"""The head of a payload, both ways."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE, PayloadHeader, code_header, profile_of
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.reference_frames import MAX_AGE
from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter

HEADERS = st.builds(
    PayloadHeader,
    st.sampled_from(sorted(PROFILES)),
    st.integers(1, MAX_FRAMES),
    st.integers(1, MAX_STRIDE),
    st.integers(1, MAX_AGE),
    st.booleans(),
)


@given(HEADERS)
def test_headers_come_back(header: PayloadHeader) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    assert code_header(writer, header) == header
    payload = writer.finish()
    assert code_header(SymbolReader(payload)) == header
    assert profile_of(payload) == PROFILES[header.profile]


@pytest.mark.parametrize(("age", "bits"), [(0, 2), (2, 3.5), (10, 7)])
def test_the_usual_header_is_short(age: int, bits: float) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    code_header(writer, PayloadHeader("live", 1, 1, age, second_reference=age > 0))
    assert writer.bits < bits


def test_every_second_payload_is_staggered() -> None:
    three = PayloadHeader("narrow", 3, 1, 0, second_reference=False)
    assert [three.is_staggered(number) for number in (0, 3, 6, 9)] == [False, True, False, True]
