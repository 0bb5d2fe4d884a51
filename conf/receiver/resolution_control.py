"""Adapt the internal resolution to the measured drawing time, so that a machine without a GPU draws 30 frames a second.

Strategy. The median of the last drawing times is compared with two limits. Above the upper one the scale falls, at once
as far as the time of the fragments asks for; it rises by one step when even the time predicted for the next step is
below the lower limit. Between the limits lies the hysteresis. A median is not moved by single slow frames, and both
limits are above the time of a machine that draws 60 frames a second, whose scale stays 1. Where fewer pixels take no
less time, as with a display of 30 Hz whose driver waits for it, the scale is restored.
"""

import math
from collections import deque
from statistics import median

# Seconds of drawing a frame. 30 frames a second leave 33 ms, of which receiving and presenting need some.
MAX_DRAW_S = 0.027
RAISE_BELOW_S = 0.022  # predicted for the next larger scale
TARGET_S = 0.024  # aimed at when the scale falls
STEPS = 16  # of the scale between 0 and 1: a change of one sixteenth is hardly visible
MIN_SCALE = 0.5  # of width and height; below it a face is blurred, and the vertices take most of the time
MIN_FALL = 2  # steps; one changes the time by too little to see whether it helps
WINDOW = 12  # frames of the median
RAISE_AFTER = 60  # frames at one scale before it rises
MIN_EFFECT = 0.2  # of what a fall saves if all of the time is spent on pixels; with less it is undone
RETRY_AFTER = 3600  # frames until the next fall after one that was undone: two minutes


class ResolutionControl:
    """Chooses the scale of the internal resolution, relative to that of the window, from drawing times.

    scale : of width and height, MIN_SCALE to 1
    """

    def __init__(self) -> None:
        self.scale = 1.0
        self._times: deque[float] = deque(maxlen=WINDOW)
        self._frames = 0  # at this scale
        self._wait = 0  # frames in which the scale does not fall
        self._before: tuple[float, float] | None = None  # scale and typical time before it fell to this scale

    def on_frame(self, draw_s: float) -> float:
        """Account for the drawing time of a frame at the current scale. Returns the scale of the next frame."""
        self._times.append(draw_s)
        self._frames += 1
        self._wait = max(self._wait - 1, 0)
        if len(self._times) == WINDOW:
            self._set(self._next(median(self._times)))
        return self.scale

    def _next(self, typical_s: float) -> float:
        """Return the scale for the typical drawing time at the current scale."""
        if self._before is not None:
            scale, before_s = self._before
            self._before = None
            if 1 - typical_s / before_s < MIN_EFFECT * (1 - (self.scale / scale) ** 2):
                self._wait = RETRY_AFTER
                return scale
        step = round(self.scale * STEPS)
        if typical_s > MAX_DRAW_S and self._wait == 0 and self.scale > MIN_SCALE:
            self._before = self.scale, typical_s
            wanted = math.floor(self.scale * math.sqrt(TARGET_S / typical_s) * STEPS)
            return max(min(wanted, step - MIN_FALL) / STEPS, MIN_SCALE)
        if step < STEPS and self._frames >= RAISE_AFTER and typical_s * ((step + 1) / step) ** 2 < RAISE_BELOW_S:
            return (step + 1) / STEPS
        return self.scale

    def _set(self, scale: float) -> None:
        if scale != self.scale:
            self.scale, self._frames = scale, 0
            self._times.clear()
