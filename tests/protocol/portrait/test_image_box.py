import pytest

from conf.errors import ProtocolError
from conf.protocol.portrait.image_box import BOX_STEPS, box_from_steps, box_to_steps


@pytest.mark.parametrize("steps", [[0, 0, BOX_STEPS, BOX_STEPS], [0, 254, 1, 255], [17, 3, 200, 90]])
def test_a_box_survives(steps: list[int]) -> None:
    assert box_to_steps(box_from_steps(steps, "photo")) == steps


@pytest.mark.parametrize("steps", [[5, 0, 5, 9], [9, 0, 5, 9], [0, 9, 5, 9], [-1, 0, 5, 9], [0, 0, 256, 9]])
def test_a_box_that_is_empty_or_outside_is_rejected(steps: list[int]) -> None:
    with pytest.raises(ProtocolError, match="an image outside the photo"):
        box_from_steps(steps, "photo")
