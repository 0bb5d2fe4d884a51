"""Lay out the panels over the image of a call so that none overlaps another.

Strategy. The statistics stand in the upper left corner, the recording sign in the upper right, messages at the lower
edge, the help in the middle of what is left. A name stands in the first free corner of its participant's cell; one
that the help leaves no corner is left out until the help is closed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

MARGIN = 8.0  # pixels at scale 1 between panels and the edge of the image
GAP = 6.0  # between panels, and between a name and the edge of its cell
ELLIPSIS = "..."

Size = tuple[float, float]  # width and height, pixels


class Rect(NamedTuple):
    """A rectangle: pixels from the upper left corner of the image, x right, y down."""

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """The x of the right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """The y of the lower edge."""
        return self.top + self.height

    def overlaps(self, other: "Rect") -> bool:
        """Return whether the two have a common pixel."""
        return (
            self.left < other.right and other.left < self.right and self.top < other.bottom and other.top < self.bottom
        )


@dataclass(frozen=True)
class PanelSizes:
    """Sizes of the panels that are to be shown, pixels; None for those that are not.

    is_open : whether the statistics are a tall panel, beside which the others stand, rather than one line
    messages : from top to bottom
    names : cell and size of the label of each participant
    """

    stats: Size
    is_open: bool = False
    recording: Size | None = None
    help: Size | None = None
    messages: Sequence[Size] = ()
    names: Sequence[tuple[Rect, Size]] = ()


@dataclass(frozen=True)
class PanelLayout:
    """Positions of the panels, in the order of PanelSizes; None for those that are not shown."""

    stats: Rect
    recording: Rect | None
    help: Rect | None
    messages: list[Rect]
    names: list[Rect | None]


def lay_out(size: tuple[int, int], scale: float, sizes: PanelSizes) -> PanelLayout:
    """Return where the panels stand in an image of `size` pixels; scale : of the interface"""
    width, height = size
    margin, gap = MARGIN * scale, GAP * scale
    stats = Rect(margin, margin, *sizes.stats)
    left = free_left(scale, sizes)
    recording = None
    top = margin if sizes.is_open else stats.bottom + gap
    if sizes.recording is not None:
        recording = Rect(width - margin - sizes.recording[0], margin, *sizes.recording)
        if recording.overlaps(stats):  # a narrow window
            recording = recording._replace(top=stats.bottom + gap)
        top = max(top, recording.bottom + gap)
    messages: list[Rect] = []
    bottom = height - margin
    for message in reversed(sizes.messages):
        messages.insert(0, Rect(_centred(left, width, message[0]), bottom - message[1], *message))
        bottom = messages[0].top - gap
    help_rect = None
    if sizes.help is not None:
        x, y = _centred(left, width, sizes.help[0]), (height - sizes.help[1]) / 2
        help_rect = Rect(x, max(min(y, bottom - sizes.help[1]), top), *sizes.help)
    taken = [rect for rect in (stats, recording, help_rect, *messages) if rect is not None]
    names: list[Rect | None] = []
    for cell, name in sizes.names:
        corners = _corners(cell, name, gap)
        found = next((corner for corner in corners if not any(corner.overlaps(other) for other in taken)), None)
        names.append(found)
        taken += [found] if found else []
    return PanelLayout(stats, recording, help_rect, messages, names)


def free_left(scale: float, sizes: PanelSizes) -> float:
    """Return the x from which the image is free of open statistics."""
    return MARGIN * scale + sizes.stats[0] if sizes.is_open else 0.0


def shorten(text: str, max_width: float, measure: Callable[[str], float]) -> str:
    """Return a text, its end replaced by an ellipsis if it is wider than `max_width` pixels."""
    if measure(text) <= max_width:
        return text
    while text and measure(text + ELLIPSIS) > max_width:
        text = text[:-1]
    return text + ELLIPSIS if text else ""


def _centred(left: float, right: float, width: float) -> float:
    return max(left, (left + right - width) / 2)


def _corners(cell: Rect, size: Size, gap: float) -> list[Rect]:
    """Return the rectangles of a label in the corners of a cell, the lower left one first."""
    lefts = cell.left + gap, cell.right - gap - size[0]
    tops = cell.bottom - gap - size[1], cell.top + gap
    return [Rect(left, top, *size) for top in tops for left in lefts]
