"""How voice packets are repeated, from the losses that reports tell. Time is an argument.

Strategy. A loss of a few per cent takes half a minute to be certain, and a call cannot wait for that. So what reports
tell is joined with a prior, some datagrams of which hardly any were lost: one lost packet of the first ten begins the
repetition, later two or three in the window. To repeat in vain costs little and each change stretches speech, so that
it ends only when a longer window shows next to no loss. The next stage makes the voice wait for longer: it needs more
and older evidence. Of packets lost in a row only the last is repeated in one that arrives: where losses come in bursts,
stages that cost more than that repairs are left out.
"""

from collections.abc import Sequence

from conf.protocol.feedback import Report
from conf.protocol.rate_control.congestion import LossEstimator
from conf.protocol.rate_control.rate_levels import LossyVoice

PRIOR_LOST, PRIOR_EXPECTED = 0.3, 8.0  # datagrams
FIRST_END, END = 0.4, 0.6  # of the loss that begins the first stage and each other
LONG_WINDOW_S, MIN_LONG = 20.0, 40  # seconds and datagrams on which all is decided but the beginning of the first stage
MIN_BURST = 2.0  # datagrams lost in a row on average; independent losses have 1.25 at 20 %
MIN_LOST = 3  # of the datagrams that a report lists, for a burst that is no chance


class Repetition:
    """The decision for one sender.

    stage : how many of a level's formats for lossy links the loss has passed: 0 for no repetition
    """

    def __init__(self) -> None:
        self.stage = 0
        self._in_bursts = False
        self._recent, self._long = LossEstimator(), LossEstimator(LONG_WINDOW_S)

    def on_report(self, report: Report, stages: Sequence[LossyVoice], now: float) -> None:
        """Apply a report. stages : of the level"""
        if report.missing.bit_count() >= MIN_LOST:
            self._in_bursts = _mean_burst(report) >= MIN_BURST
        self._recent.on_report(report, now)
        self._long.on_report(report, now)
        stage = 0
        for number, lossy in enumerate(stages, 1):
            if not self._is_reached(number, lossy.loss) or (self._in_bursts and not lossy.in_bursts):
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


def _mean_burst(report: Report) -> float:
    """Return how many datagrams were lost in a row, of those that a report lists."""
    return report.missing.bit_count() / (report.missing & ~(report.missing << 1)).bit_count()
