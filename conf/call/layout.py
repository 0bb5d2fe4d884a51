"""Lay out the window of a call so that nothing overlaps.

Strategy. What is shown is placed in order of importance, each in the first of its possible positions that is free and
inside the window; what has none is left out, in a tiny window nearly all.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from conf.receiver.panel_layout import GAP, MARGIN, Rect, Size

SELF_WIDTH = 0.21  # of the window's width: one's own image
SELF_HEIGHT = 0.26  # of its height, at most


@dataclass(frozen=True)
class CallSizes:
    """Sizes of what is to be shown, pixels; None for what is not.

    status : the line about the call; stats : what it costs
    notice : about the call in the middle, such as the code while one waits
    self_aspect : width over height of one's own image
    name : of the other participant
    messages : from top to bottom
    """

    status: Size
    toolbar: Size | None = None
    stats: Size | None = None
    notice: Size | None = None
    recording: Size | None = None
    help: Size | None = None
    self_aspect: float | None = None
    name: Size | None = None
    messages: Sequence[Size] = ()


@dataclass(frozen=True)
class CallLayout:
    """Positions, in the order of CallSizes; None for what is not shown or has no room."""

    status: Rect | None
    toolbar: Rect | None
    stats: Rect | None
    notice: Rect | None
    recording: Rect | None
    help: Rect | None
    own: Rect | None
    name: Rect | None
    messages: list[Rect | None]


class _Space:
    """The window and what has been placed in it."""

    def __init__(self, size: tuple[int, int], gap: float) -> None:
        self._window = Rect(0.0, 0.0, *size)
        self._gap = gap
        self.taken: list[Rect] = []

    def place(self, candidates: Iterable[Rect]) -> Rect | None:
        """Take the first candidate that is free and inside the window."""
        for rect in candidates:
            if self._is_inside(rect) and not any(self._grown(rect).overlaps(other) for other in self.taken):
                self.taken.append(rect)
                return rect
        return None

    def _is_inside(self, rect: Rect) -> bool:
        return (
            rect.left >= 0 and rect.top >= 0 and rect.right <= self._window.right and rect.bottom <= self._window.bottom
        )

    def _grown(self, rect: Rect) -> Rect:
        half = self._gap * 0.99
        return Rect(rect.left - half, rect.top - half, rect.width + 2 * half, rect.height + 2 * half)


def lay_out_call(size: tuple[int, int], scale: float, sizes: CallSizes) -> CallLayout:
    """Return where everything stands in a window of `size` pixels; scale : of the interface"""
    width, height = size
    margin, gap = MARGIN * scale, GAP * scale
    space = _Space(size, gap)
    bottom = height - margin

    def placed(item: Size | None, candidates: Iterable[tuple[float, float]]) -> Rect | None:
        return None if item is None else space.place(Rect(x, y, *item) for x, y in candidates)

    def centred(item: Size | None) -> float:
        return (width - (item[0] if item else 0.0)) / 2

    toolbar = placed(
        sizes.toolbar, [(centred(sizes.toolbar), bottom - sizes.toolbar[1])] if sizes.toolbar is not None else []
    )
    floor = toolbar.top - gap if toolbar else bottom
    status = placed(sizes.status, [(margin, margin)])
    top = status.bottom + gap if status else margin
    notice = None
    if sizes.notice is not None:
        x, y = centred(sizes.notice), (height - sizes.notice[1]) / 2
        notice = placed(sizes.notice, _slid(x, y, floor - sizes.notice[1], top))
    recording = None
    if sizes.recording is not None:
        x = width - margin - sizes.recording[0]
        recording = placed(sizes.recording, [(x, margin), (x, top)])
    stats = placed(sizes.stats, [(margin, top)])
    help_rect = None
    if sizes.help is not None:
        lefts = [centred(sizes.help)] + ([stats.right + gap] if stats else [])
        y = (height - sizes.help[1]) / 2
        help_rect = placed(sizes.help, [place for x in lefts for place in _slid(x, y, floor - sizes.help[1], top)])
    own = _place_own(space, size, scale, sizes.self_aspect, floor) if sizes.self_aspect is not None else None
    name = None
    if sizes.name is not None:
        lefts = [margin] + ([stats.right + gap] if stats else [])
        name = placed(sizes.name, [(x, y - sizes.name[1]) for x in lefts for y in (bottom, floor)])
    messages = _place_messages(space, sizes.messages, (width, floor), gap)
    return CallLayout(status, toolbar, stats, notice, recording, help_rect, own, name, messages)


def _slid(x: float, y: float, lowest: float, highest: float) -> list[tuple[float, float]]:
    """Return a position and those to which it is moved if it is too low or too high."""
    return [(x, y), (x, min(y, lowest)), (x, max(y, highest)), (x, highest)]


def _place_own(space: _Space, size: tuple[int, int], scale: float, aspect: float, floor: float) -> Rect | None:
    """Place one's own image in a corner at the right, lower if it can be."""
    width, height = size
    margin, gap = MARGIN * scale, GAP * scale
    own_width = min(SELF_WIDTH * width, SELF_HEIGHT * height * aspect)
    own_height = own_width / aspect
    left = width - margin - own_width
    tops = (height - margin - own_height, floor - own_height, margin, margin + 40 * scale + gap)
    return space.place(Rect(left, y, own_width, own_height) for y in tops)


def _place_messages(
    space: _Space, messages: Sequence[Size], area: tuple[float, float], gap: float
) -> list[Rect | None]:
    """Place messages one above another, in the middle, where nothing else stands."""
    width, floor = area
    places: list[Rect | None] = []
    bottom = floor
    for message in reversed(messages):
        x = (width - message[0]) / 2
        tops = [bottom - message[1]]
        tops += sorted((rect.top - gap - message[1] for rect in space.taken if rect.top - gap < bottom), reverse=True)
        place = space.place(Rect(x, y, *message) for y in tops)
        places.insert(0, place)
        bottom = place.top - gap if place else bottom
    return places
