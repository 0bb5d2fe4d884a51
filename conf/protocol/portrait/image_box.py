"""The part of the photo, or of a frame, that a smaller image shows: four integers in an object's array."""

from collections.abc import Sequence

from conf.errors import ProtocolError

BOX_STEPS = 255  # from one border of the frame to the other

# Left, top, right and bottom of the image in its frame, 0 to 1 from the upper left corner.
Box = tuple[float, float, float, float]


def box_to_steps(box: Box, /) -> list[int]:
    """Return the four integers of a box."""
    return [round(side * BOX_STEPS) for side in box]


def box_from_steps(steps: Sequence[int], whole: str, /) -> Box:
    """Return the box of four integers. Raises ProtocolError, which names the `whole`, if it is empty or outside."""
    left, top, right, bottom = steps
    if not (0 <= left < right <= BOX_STEPS and 0 <= top < bottom <= BOX_STEPS):
        raise ProtocolError(f"an image outside the {whole}")
    return left / BOX_STEPS, top / BOX_STEPS, right / BOX_STEPS, bottom / BOX_STEPS
