"""Decide at what time a frame of a file is shown: the stated times may be missing, guessed or wrong."""

import math

MAX_PAUSE_S = 5.0  # a longer step between two frames is a fault of the file
MAX_GLITCH_S = 0.5  # a larger correction is a part of the file with times of its own, as in files that were joined


class TimestampChoice:
    """Chooses between the presentation and the decoding time of each decoded frame, in the order of presentation.

    The one that has failed to rise less often is right; of a well-made file both are the same there.
    Source: guess_correct_pts in FFmpeg's libavcodec/decode.c.
    """

    def __init__(self, *, has_presentation_times: bool = True) -> None:
        """has_presentation_times : False for AVI, of which FFmpeg guesses them, and wrongly with B-frames of H.264"""
        self._faults = {"pts": 0 if has_presentation_times else 1, "dts": 0}
        self._last: dict[str, int] = {}

    def choose(self, pts: int | None, dts: int | None, /) -> int | None:
        """Return one of the times of the next frame, in ticks, or None if it has neither."""
        for name, value in (("pts", pts), ("dts", dts)):
            if value is not None:
                self._faults[name] += value <= self._last.get(name, value - 1)
                self._last[name] = value
        return pts if pts is not None and self._faults["pts"] <= self._faults["dts"] else dts


class PlausibleTime:
    """Turns the times that a file states into times that rise: from the first frame, or on from the last round.

    offset : what is added to the file's times, seconds
    """

    def __init__(self, first: float) -> None:
        """first : stated time of the first frame, seconds"""
        self.last: float | None = None
        self._own_offset = self._offset = -first

    @property
    def offset(self) -> float:
        """What is added to the file's times, seconds."""
        return self._offset

    def restart(self, first: float, at: float, /) -> None:
        """Begin a new round: its first frame, at the stated time `first`, is shown at `at`."""
        self._own_offset = self._offset = at - first

    def of(self, stated: float, fps: float, /) -> float:
        """Return the time of the next frame, seconds: the stated one if it is plausible, else the last plus 1/fps.

        After a false time the file's own are trusted again as soon as they are plausible.
        """
        if self.last is None:
            self.last = 0.0
            return 0.0
        is_glitch = abs(self._offset - self._own_offset) <= MAX_GLITCH_S
        for offset in (self._own_offset, self._offset) if is_glitch else (self._offset,):
            at = offset + stated
            if math.isfinite(at) and 0 < at - self.last <= MAX_PAUSE_S:
                self._offset, self.last = offset, at
                return at
        self.last += 1 / fps
        if math.isfinite(stated):
            self._offset = self.last - stated
        return self.last
