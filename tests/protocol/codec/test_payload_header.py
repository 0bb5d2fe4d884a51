"""The payload header: both directions agree, and its tables are those of WIRE.md."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE, PayloadHeader, code_header, profile_of
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.reference_frames import MAX_AGE
from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from tests.protocol.independent_decoder import weighted

HEADERS = st.builds(
    PayloadHeader,
    st.sampled_from(sorted(PROFILES)),
    st.integers(1, MAX_FRAMES),
    st.integers(1, MAX_STRIDE),
    st.integers(1, MAX_AGE),
    st.booleans(),
)


class RecordingWriter(SymbolWriter):
    """A writer that records its tables and symbols."""

    def __init__(self) -> None:
        super().__init__(rd_lambda=0.0)
        self.symbols: list[tuple[list[int], int]] = []

    def symbol(self, cumulative: object, value: int) -> int:
        """Write and record one symbol."""
        assert isinstance(cumulative, list)
        self.symbols.append((cumulative, value))
        return super().symbol(cumulative, value)


@given(HEADERS)
def test_headers_are_read_as_they_were_written(header: PayloadHeader) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    assert code_header(writer, header) == header
    payload = writer.finish()
    assert code_header(SymbolReader(payload)) == header
    assert profile_of(payload) == PROFILES[header.profile]


@pytest.mark.parametrize(
    ("profile", "index", "frames"),
    [("live", 0, {1}), ("rich", 1, {2}), ("narrow", 2, {3}), ("voice", 3, {1, 2}), ("slow", 4, {3, 6})],
)
def test_symbols_and_tables_are_those_of_wire_md(profile: str, index: int, frames: set[int]) -> None:
    writer = RecordingWriter()
    code_header(writer, PayloadHeader(profile, 8, 4, 63, second_reference=True))
    assert writer.symbols == [
        (weighted([30, 2, 2, 2, 2]), index),
        (weighted([300 if count in frames else 1 for count in range(1, 9)]), 7),
        (weighted([300, 3, 1, 1]), 3),
        (weighted([60, 15, 32, *(19 / age for age in range(3, 64))]), 63),
        (weighted([1, 40]), 1),
    ]


def test_without_reference_there_is_no_second_reference() -> None:
    writer = RecordingWriter()
    header = code_header(writer, PayloadHeader("live", 1, 1, 0, second_reference=True))
    assert (len(writer.symbols), header.second_reference) == (4, False)


@pytest.mark.parametrize(("age", "bits"), [(0, 2), (2, 3.5), (10, 7)])
def test_the_usual_header_is_short(age: int, bits: float) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    code_header(writer, PayloadHeader("live", 1, 1, age, second_reference=age > 0))
    assert writer.bits < bits


def test_every_second_payload_is_staggered() -> None:
    three = PayloadHeader("narrow", 3, 2, 0, second_reference=False)
    assert [three.is_staggered(number) for number in (0, 5, 6, 11, 12, 17, 18)] == [0, 0, 1, 1, 0, 0, 1]
