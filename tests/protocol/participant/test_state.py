"""Names are safe to show."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.participant.state import MAX_NAME_BYTES, clean_name


@pytest.mark.parametrize(
    ("name", "cleaned"),
    [
        ("Ada", "Ada"),
        ("  Ada \t Lovelace\n", "Ada Lovelace"),
        ("Ada\x1b[31m\x00", "Ada[31m"),
        ("\u202eadA\u202c\u200b", "adA"),
        ("ÅÄÖ ☺ 日本", "ÅÄÖ ☺ 日本"),
        ("x" * 40, "x" * 32),
        ("日" * 11, "日" * 10),
        ("x" * 31 + " y", "x" * 31),
        ("\ud800A", "A"),
        ("", ""),
    ],
)
def test_what_draws_nothing_goes_and_the_rest_is_cut_at_a_character(name: str, cleaned: str) -> None:
    assert clean_name(name) == cleaned


@given(st.text(st.characters()))
def test_any_text_becomes_a_name_of_limited_length(name: str) -> None:
    cleaned = clean_name(name)
    assert len(cleaned.encode()) <= MAX_NAME_BYTES
    assert clean_name(cleaned) == cleaned
    assert not any(unicodedata.category(character)[0] == "C" for character in cleaned)
