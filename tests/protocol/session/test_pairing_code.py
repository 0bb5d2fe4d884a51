"""The pairing code: what is shown is what is read, whatever case and separators people use."""

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.pairing_code import (
    NUMBERS,
    WORDS,
    generate_code,
    generate_nameplate,
    is_nameplate,
    is_relay_code,
    nameplate_of,
    normalise_code,
)
from tests.support.simulated_sessions import seeded

CODES = st.tuples(st.sampled_from(WORDS), st.sampled_from(WORDS), st.sampled_from(WORDS), st.integers(0, NUMBERS - 1))


@pytest.mark.slow
def test_words_are_256_and_no_two_are_one_letter_apart() -> None:
    assert len(set(WORDS)) == 256
    assert all(word.isascii() and word.islower() and 4 <= len(word) <= 8 for word in WORDS)
    for one, other in combinations(WORDS, 2):
        differing = sum(a != b for a, b in zip(one, other, strict=False)) + abs(len(one) - len(other))
        assert differing > 1, (one, other)


@pytest.mark.slow
@given(st.integers())
def test_a_generated_code_is_in_normal_form(seed: int) -> None:
    code = generate_code(seeded(seed))
    assert normalise_code(code) == code


def test_codes_use_all_words_and_numbers() -> None:
    random = seeded("spread")
    codes = [generate_code(random).split("-") for _ in range(4000)]
    assert {word for *words, _ in codes for word in words} == set(WORDS)
    assert {int(number) for *_, number in codes} == set(range(NUMBERS))


@pytest.mark.slow
@given(CODES, st.sampled_from(["-", " ", "  ", " - ", "_", ", ", "."]), st.booleans())
def test_case_and_separators_do_not_matter(parts: tuple[str, str, str, int], between: str, upper: bool) -> None:
    text = between.join(map(str, parts))
    assert normalise_code(f"  {text.upper() if upper else text.title()}\n") == "-".join(map(str, parts))


def test_leading_zero_and_missing_space_before_the_number() -> None:
    assert normalise_code("acorn tulip river07") == "acorn-tulip-river-7"


def test_a_code_has_at_most_80_characters() -> None:
    assert normalise_code("acorn-tulip-river-42".ljust(80)) == "acorn-tulip-river-42"
    with pytest.raises(ValueError, match="a code is three words and a number"):
        normalise_code("acorn-tulip-river-42".ljust(81))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a code is three words and a number, such as acorn-tulip-river-42"),
        ("acorn-tulip-river", "a code is three words and a number"),
        ("acorn-tulip-river-42!", "a code is three words and a number"),
        ("acorn-tulip-river-42-42", "a code is three words and a number"),
        ("acorn-" * 1000, "a code is three words and a number"),
        ("4711-acorn-tulip", "a code for a relay is a number and three words, such as 4711-acorn-tulip-river"),
        ("42-acorn-tulip-river", "a code for a relay begins with a number of 3 to 9 digits"),
        ("1234567890-acorn-tulip-river", "begins with a number of 3 to 9 digits"),
        ("4711-acorn-tulip-rivr", "'rivr' is not a word of any code: did you mean 'river'?"),
        ("4711-acorn-tulip-42", "'42' is not a word of any code"),
        ("acorn-tulip-42-river", "'42' is not a word of any code"),
        ("acorn-tulip-rivr-42", "'rivr' is not a word of any code: did you mean 'river'?"),
        ("acorn-tulip-river-100", "a code ends in a number from 0 to 99, not in '100'"),
        ("acorn-tulip-river-river", "a code ends in a number from 0 to 99, not in 'river'"),
    ],
)
def test_invalid_codes_are_explained(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message.replace("?", r"\?")):
        normalise_code(text)


@pytest.mark.slow
@given(st.text(max_size=100))
def test_any_text_is_a_code_or_a_value_error(text: str) -> None:
    try:
        code = normalise_code(text)
    except ValueError:
        return
    assert normalise_code(code) == code


@given(st.integers(), st.integers(3, 9))
def test_a_code_for_a_relay_begins_with_its_nameplate(seed: int, digits: int) -> None:
    random = seeded(seed)
    nameplate = generate_nameplate(random, digits=digits)
    code = generate_code(random, nameplate=nameplate)
    assert len(nameplate) == digits and nameplate[0] != "0" and nameplate_of(code) == nameplate
    assert normalise_code(code) == normalise_code(code.replace("-", " ").upper()) == code and is_relay_code(code)


def test_nameplates_are_spread() -> None:
    random = seeded("plates")
    numbers = [int(generate_nameplate(random)) for _ in range(2000)]
    assert min(numbers) < 1050 and max(numbers) > 9950 and len(set(numbers)) > 1700


@pytest.mark.parametrize("text", ["4711-acorn-tulip-river", "4711 Acorn Tulip Rivr", " 1-a-b-c "])
def test_what_looks_like_a_code_for_a_relay(text: str) -> None:
    assert is_relay_code(text)


@pytest.mark.parametrize("text", ["acorn-tulip-river-42", "10.0.0.1", "host-1-a-b", "4711", "4711-acorn-tulip"])
def test_what_does_not(text: str) -> None:
    assert not is_relay_code(text)


def test_a_nameplate_is_a_number_of_three_to_nine_digits() -> None:
    assert all(map(is_nameplate, ("471", "4711", "999999999")))
    assert not any(map(is_nameplate, ("47", "0471", "1000000000", "4711-acorn-tulip-river", "10.0.0.1", "", "٤٧١١")))


def test_a_code_for_direct_calls_has_no_nameplate() -> None:
    assert nameplate_of("acorn-tulip-river-42") == ""
