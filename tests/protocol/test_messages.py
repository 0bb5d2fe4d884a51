"""Messages are immutable."""

import dataclasses
from typing import get_args

import pytest

from conf.protocol import messages


@pytest.mark.parametrize("message", [*get_args(messages.Body), messages.MotionFrame], ids=lambda cls: cls.__name__)
def test_messages_are_frozen(message: type) -> None:
    names = [field.name for field in dataclasses.fields(message)]
    instance = message(*names)
    for name in names:
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(instance, name, None)


def test_the_clock_of_parameters_starts_at_zero() -> None:
    assert messages.StreamParameters(1, 1, 1.0, 1, ()).clock == 0
    assert [(presence.name, presence.value) for presence in messages.Presence] == [("FACE", 0), ("NO_FACE", 1)]
