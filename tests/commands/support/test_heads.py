import pytest

from conf.commands.support.heads import head_loader, head_number
from conf.errors import ConfError


def test_a_name_stands_for_a_number() -> None:
    assert [head_number(name) for name in (None, "alex", " Maria ")] == [0, 1, 2]


def test_an_unknown_name_is_explained() -> None:
    with pytest.raises(ConfError, match=r"^there is no head 'bob': choose one of alex, maria, "):
        head_number("bob")


def test_with_a_face_of_ones_own_no_head_is_loaded() -> None:
    assert head_loader("face.obj") is None and head_loader(None) is not None
