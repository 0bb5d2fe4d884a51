"""Emotions that the viewer lays over whoever is shown: the motion of a call goes on under them."""

from dataclasses import replace

import numpy as np

from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import TimedExpression, blend_without_doubling
from conf.protocol.messages import MotionFrame


class ExpressionOverlay:
    """What has been asked for and has not gone yet."""

    def __init__(self) -> None:
        self._played: tuple[TimedExpression, ...] = ()

    def play(self, number: int, now: float) -> str:
        """Begin an emotion, by its number from 1; what is under way fades. Returns its name."""
        emotions = load_emotions()
        fading = tuple(performance.released(now) for performance in self._played)
        self._played = (*fading, TimedExpression(emotions.displacements[number - 1], now))
        return emotions.names[number - 1]

    def apply(self, frame: MotionFrame, now: float) -> MotionFrame:
        """Return a caller's motion with the emotions laid over it."""
        self._played = tuple(performance for performance in self._played if not performance.is_finished(now))
        if not self._played:
            return frame
        emotion = np.sum([performance.at(now) for performance in self._played], axis=0)
        return replace(frame, displacements=blend_without_doubling(frame.displacements, emotion))
