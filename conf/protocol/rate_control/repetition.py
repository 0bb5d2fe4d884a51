"""How voice packets are repeated, from the losses that reports tell. Time is an argument.

Strategy. A loss of a few per cent takes half a minute to be certain, and a call cannot wait for that. So what reports
tell is joined with a prior, some datagrams of which hardly any were lost: one lost packet of the first ten begins the
repetition, later two or three in the window. To repeat in vain costs little and each change stretches speech, so that
it ends only when a longer window shows next to no loss. The next stage makes the voice wait for longer: it needs more
and older evidence.
"""

from collections.abc import Sequence

from conf.protocol.feedback import Report
from conf.protocol.rate_control.congestion import LossEstimator

PRIOR_LOST, PRIOR_EXPECTED = 0.3, 8.0  # datagrams
FIRST_END, END = 0.4, 0.6  # of the loss that begins the first stage and each other
LONG_WINDOW_S, MIN_LONG = 20.0, 40  # seconds and datagrams on which all is decided but the beginning of the first stage


class Repetition:
    """The decision for one sender.

    stage : how many of the thresholds the loss has passed: 0 for no repetition
    """

    def __init__(self) -> None:
        self.stage = 0
        self._recent, self._long = LossEstimator(), LossEstimator(LONG_WINDOW_S)

    def on_report(self, report: Report, thresholds: Sequence[float], now: float) -> None:
        """Apply a report. thresholds : losses from which each stage is better than the one before, 0 to 1, rising"""
        self._recent.on_report(report, now)
        self._long.on_report(report, now)
        stage = 0
        for number, threshold in enumerate(thresholds, 1):
            if not self._is_reached(number, threshold):
                break
            stage = number
        self.stage = stage

    def _is_reached(self, stage: int, threshold: float) -> bool:
        is_first, is_certain = stage == 1, self._long.expected >= MIN_LONG
        if self.stage >= stage:
            return not is_certain or _estimate(self._long) > (FIRST_END if is_first else END) * threshold
        return _estimate(self._recent) > threshold if is_first else is_certain and _estimate(self._long) > threshold


def _estimate(loss: LossEstimator) -> float:
    return (loss.fraction * loss.expected + PRIOR_LOST) / (loss.expected + PRIOR_EXPECTED)
