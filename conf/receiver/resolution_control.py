"""Adapt resolution and rate of the heads to the measured drawing time: 30 frames a second without a GPU.

Strategy. The median of the last drawing times is compared with two limits. Above the upper one less is drawn: of
several heads each in every second frame, as most senders send 15 frames a second; then fewer pixels, at once as few as
the time asks for; then each head in every third frame. More is drawn, step by step in the opposite order, when even the
time predicted for it is below the lower limit. Between the limits lies the hysteresis. A median is not moved by single
slow frames, and both limits are above the time of a machine that draws 60 frames a second, which draws everything.
Where drawing less takes no less time, as with a display of 30 Hz whose driver waits for it, it is undone.
"""

import math
from collections import deque
from dataclasses import dataclass, replace
from statistics import median

# Seconds of drawing a frame. 30 frames a second leave 33 ms, of which receiving and presenting need some.
MAX_DRAW_S = 0.027
RAISE_BELOW_S = 0.022  # predicted for the next finer detail
TARGET_S = 0.024  # aimed at when the scale falls
STEPS = 16  # of the scale between 0 and 1: a change of one sixteenth is hardly visible
MIN_SCALE = 0.5  # of width and height; below it a face is blurred, and the vertices take most of the time
MIN_FALL = 2  # steps; one changes the time by too little to see whether it helps
FIRST_INTERVAL, MAX_INTERVAL = 2, 3  # frames; before the scale falls, and at the lowest scale
WINDOW = 12  # frames of the median
RAISE_AFTER = 60  # frames with one detail before it rises
MIN_EFFECT = 0.2  # of what drawing less saves if all of the time is spent on it; with less it is undone
RETRY_AFTER = 3600  # frames until the next attempt after one that was undone: two minutes


@dataclass(frozen=True)
class DrawingDetail:
    """How finely heads are drawn.

    scale : of the internal resolution relative to the window's, width and height, MIN_SCALE to 1
    interval : of several heads each is drawn in every frame (1), every second one (2) and so on
    """

    scale: float = 1.0
    interval: int = 1

    @property
    def effort(self) -> float:
        """Drawing time relative to that of the finest detail, if it is all spent on pixels of heads."""
        return self.scale**2 / self.interval


class ResolutionControl:
    """Chooses the detail from drawing times.

    detail : of the next frame
    """

    def __init__(self) -> None:
        self.detail = DrawingDetail()
        self._times: deque[float] = deque(maxlen=WINDOW)
        self._frames = 0  # with this detail
        self._retry_scale = self._retry_interval = 0  # frames in which either is not lowered
        self._before: tuple[DrawingDetail, float] | None = None  # detail and typical time before it fell to this one

    def on_frame(self, draw_s: float, *, cells: int = 1) -> DrawingDetail:
        """Account for the drawing time of a frame with the current detail. Returns the detail of the next frame.

        cells : how many heads there are
        """
        self._times.append(draw_s)
        self._frames += 1
        self._retry_scale, self._retry_interval = (max(n - 1, 0) for n in (self._retry_scale, self._retry_interval))
        if self.detail.interval > max(cells, 1):  # callers have left
            self._before = None
            self._set(replace(self.detail, interval=max(cells, 1)))
        elif len(self._times) == WINDOW:
            self._set(self._next(median(self._times), cells))
        return self.detail

    def _next(self, typical_s: float, cells: int) -> DrawingDetail:
        """Return the detail for the typical drawing time with the current one."""
        if self._before is not None:
            before, before_s = self._before
            self._before = None
            if 1 - typical_s / before_s < MIN_EFFECT * (1 - self.detail.effort / before.effort):
                if before.interval < self.detail.interval:
                    self._retry_interval = RETRY_AFTER
                else:
                    self._retry_scale = RETRY_AFTER
                return before
        if typical_s > MAX_DRAW_S:
            lower = self._lower(typical_s, cells)
            if lower != self.detail:
                self._before = self.detail, typical_s
            return lower
        finer = self._finer()
        if self._frames >= RAISE_AFTER and typical_s * finer.effort / self.detail.effort < RAISE_BELOW_S:
            return finer
        return self.detail

    def _lower(self, typical_s: float, cells: int) -> DrawingDetail:
        scale, interval = self.detail.scale, self.detail.interval
        longest = 1 if self._retry_interval else min(cells, MAX_INTERVAL)
        if interval < min(longest, FIRST_INTERVAL):
            return replace(self.detail, interval=interval + 1)
        if scale > MIN_SCALE and not self._retry_scale:
            wanted = math.floor(scale * math.sqrt(TARGET_S / typical_s) * STEPS)
            return replace(self.detail, scale=max(min(wanted, round(scale * STEPS) - MIN_FALL) / STEPS, MIN_SCALE))
        return replace(self.detail, interval=interval + 1) if interval < longest else self.detail

    def _finer(self) -> DrawingDetail:
        """Return the next finer detail, the current one if it is the finest."""
        scale, interval = self.detail.scale, self.detail.interval
        if interval > FIRST_INTERVAL or (interval > 1 and scale == 1.0):
            return replace(self.detail, interval=interval - 1)
        return replace(self.detail, scale=min((round(scale * STEPS) + 1) / STEPS, 1.0))

    def _set(self, detail: DrawingDetail) -> None:
        if detail != self.detail:
            self.detail, self._frames = detail, 0
            self._times.clear()
