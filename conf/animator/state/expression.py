"""What plays on the face beside a recording: emotions that come and go, action units held by sliders, idle life."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.animation.action_units import combine_action_units
from conf.face.animation.timed_expression import Envelope, TimedExpression
from conf.face.control_points import CONTROL_POINT_COUNT


@dataclass(frozen=True)
class RunningExpression:
    """An emotion under way."""

    name: str
    performance: TimedExpression


@dataclass(frozen=True)
class ExpressionState:
    """What the panel of emotions says. Every change gives a new one.

    envelope : how the next emotion comes, stays and goes
    stays : whether it stays until it is released, whatever the envelope's hold
    units : action unit -> strength, those that are not 0
    idle : whether the face blinks, glances and sways by itself
    """

    envelope: Envelope = field(default_factory=Envelope)
    hold_until_released: bool = False
    played: tuple[RunningExpression, ...] = ()
    units: Mapping[int, float] = field(default_factory=dict)
    idle: bool = True

    def play(self, name: str, displacements: NDArray[np.float32], now: float) -> "ExpressionState":
        """Begin an emotion, (n, 3) FAPU units; others that are under way fade."""
        envelope = replace(self.envelope, hold=math.inf) if self.hold_until_released else self.envelope
        fading = self.release(now).played
        return replace(self, played=(*fading, RunningExpression(name, TimedExpression(displacements, now, envelope))))

    def release(self, now: float) -> "ExpressionState":
        """Let every emotion fade from now on."""
        return replace(self, played=tuple(replace(p, performance=p.performance.released(now)) for p in self.played))

    def without_finished(self, now: float) -> "ExpressionState":
        """Forget the emotions that are over."""
        left = tuple(played for played in self.played if not played.performance.is_finished(now))
        return self if len(left) == len(self.played) else replace(self, played=left)

    def active(self, now: float) -> str | None:
        """Return the name of the emotion that plays and is not fading yet."""
        return next((p.name for p in reversed(self.played) if p.performance.released_at > now), None)

    def set_unit(self, unit: int, strength: float) -> "ExpressionState":
        """Hold an action unit at a strength, 0 to 1."""
        units = {**self.units, unit: strength}
        return replace(self, units={number: value for number, value in units.items() if value})

    def at(self, now: float) -> NDArray[np.float32]:
        """Return the (n, 3) displacements, FAPU units, of everything but the idle life, at a time in seconds."""
        total = combine_action_units(self.units) if self.units else np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
        for played in self.played:
            total += played.performance.at(now)
        return total
