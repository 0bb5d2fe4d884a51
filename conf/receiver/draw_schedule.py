"""Decide when the next frame of a window is drawn."""


class DrawSchedule:
    """A frame rate that gives way to datagrams in a flood.

    In a flood, when each step of a loop receives a full batch of datagrams, the frame waits, but no longer than drawing
    the last one took: a machine that draws slowly spends as much time on receiving.
    """

    def __init__(self, fps: float) -> None:
        """fps : maximum frame rate"""
        self._interval = 1 / fps
        self._due: float | None = None
        self._flood_deadline = 0.0
        self._drawing_since: float | None = None

    def is_due(self, now: float, *, is_flood: bool) -> bool:
        """Return whether a frame is to be drawn now, which the next call takes to be finished."""
        if self._due is None:
            self._due = now
        if self._drawing_since is not None:
            self._due = max(self._due + self._interval, now - self._interval)
            self._flood_deadline = max(self._due, now + now - self._drawing_since)
            self._drawing_since = None
        if now < (self._flood_deadline if is_flood else self._due):
            return False
        self._drawing_since = now
        return True

    def next_step(self, now: float) -> float:
        """Return the time at which `is_due` must be called again: at once after a frame, to learn how long it took."""
        return now if self._drawing_since is not None or self._due is None else self._due
