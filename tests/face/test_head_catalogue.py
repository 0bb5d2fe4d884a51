"""The table of heads, and the files that belong to it."""

import pytest

from conf.face.head_catalogue import DEFAULT_NUMBER, HEADS, HEADS_BY_NAME, HEADS_BY_NUMBER, MAX_HEAD_NUMBER, find_head
from conf.protocol.participant.state import MAX_HEAD
from tools.assets.head.parameters import TABLES, read_parameters

OTHERS = [head for head in HEADS if not head.is_default]


def test_names_and_numbers_are_unique_and_fit_the_wire() -> None:
    assert len(HEADS_BY_NAME) == len(HEADS_BY_NUMBER) == len(HEADS) >= 6
    assert all(0 < head.number <= MAX_HEAD_NUMBER for head in HEADS) and MAX_HEAD_NUMBER == MAX_HEAD
    assert all(name == name.lower() and name.isalpha() for name in HEADS_BY_NAME)
    assert HEADS[0].is_default and HEADS[0].number == DEFAULT_NUMBER


def test_an_unknown_number_is_the_default_head() -> None:
    assert find_head(3).number == 3
    assert find_head(0).is_default and find_head(MAX_HEAD_NUMBER).is_default


@pytest.mark.parametrize("head", OTHERS, ids=lambda head: head.name)
def test_each_head_has_its_files_and_its_table(head: object) -> None:
    parameters = read_parameters(TABLES / f"{head.name}.toml")  # type: ignore[attr-defined]
    assert (parameters.number, parameters.about) == (head.number, head.about)  # type: ignore[attr-defined]


def test_the_files_are_small() -> None:
    sizes = [path.stat().st_size for head in OTHERS for path in (head.path, head.path.with_suffix(".webp"))]
    assert sum(sizes) < 3_000_000 and max(sizes) < 300_000
    assert len(list(OTHERS[0].path.parent.iterdir())) == 2 * len(OTHERS)
