import dataclasses

import pytest

from tests.protocol.motion.test_inbound import PARAMETERS


def test_messages_do_not_change_behind_anyones_back() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        PARAMETERS.width = 1  # type: ignore[misc]
