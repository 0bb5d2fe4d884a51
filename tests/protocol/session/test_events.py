"""Events are values that can be compared, matched and stored."""

from dataclasses import is_dataclass
from typing import get_args

import pytest

from conf.protocol.session.events import Connected, Event


@pytest.mark.parametrize("kind", get_args(Event))
def test_events_are_frozen_dataclasses_with_a_docstring(kind: type) -> None:
    assert is_dataclass(kind)
    assert kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    assert kind.__doc__


def test_equal_events_are_equal() -> None:
    assert Connected(1, ("a", 2)) == Connected(1, ("a", 2))
