"""Emotions that the viewer adds to the received motion."""

from dataclasses import replace

import numpy as np

from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import TimedExpression, blend_without_doubling
from conf.protocol.messages import MotionFrame


class ExpressionOverlay:
    """The emotions that are playing."""

    def __init__(self) -> None:
        self._playing: tuple[TimedExpression, ...] = ()

    def play(self, number: int, now: float) -> str:
        """Start an emotion, numbered from 1, and fade out the others. Returns its name."""
        emotions = load_emotions()
        fading = tuple(expression.released(now) for expression in self._playing)
        self._playing = (*fading, TimedExpression(emotions.displacements[number - 1], now))
        return emotions.names[number - 1]

    def apply(self, frame: MotionFrame, now: float) -> MotionFrame:
        """Return a frame of received motion with the emotions added."""
        self._playing = tuple(expression for expression in self._playing if not expression.is_finished(now))
        if not self._playing:
            return frame
        emotion = np.sum([expression.at(now) for expression in self._playing], axis=0)
        return replace(frame, displacements=blend_without_doubling(frame.displacements, emotion))
