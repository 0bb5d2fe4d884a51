"""State of the expressions panel: running expressions, action-unit intensities, idle motion on or off."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.animation.action_units import combine_action_units
from conf.face.animation.timed_expression import Envelope, TimedExpression
from conf.face.control_points import CONTROL_POINT_COUNT


@dataclass(frozen=True)
class ExpressionState:
    """Immutable expression state.

    envelope : of the next expression
    hold_until_released : whether the next expression ignores the envelope's hold and stays until `release`
    running : in the order of their start
    units : action unit -> intensity, 0 to 1; units at 0 are left out
    idle : whether the face blinks, glances and sways while no recording plays
    """

    envelope: Envelope = field(default_factory=Envelope)
    hold_until_released: bool = False
    running: tuple[TimedExpression, ...] = ()
    units: Mapping[int, float] = field(default_factory=dict)
    idle: bool = True

    def play(self, name: str, displacements: NDArray[np.float32], now: float) -> "ExpressionState":
        """Start an expression, (n, 3) FAPU units; running ones fade out."""
        envelope = replace(self.envelope, hold=math.inf) if self.hold_until_released else self.envelope
        started = TimedExpression(displacements, now, envelope, name=name)
        return replace(self, running=(*self.release(now).running, started))

    def release(self, now: float) -> "ExpressionState":
        """Start the release phase of every running expression."""
        return replace(self, running=tuple(e.released(now) for e in self.running))

    def without_finished(self, now: float) -> "ExpressionState":
        """Remove finished expressions."""
        running = tuple(e for e in self.running if not e.is_finished(now))
        return self if len(running) == len(self.running) else replace(self, running=running)

    def active(self, now: float) -> str | None:
        """Return the name of the newest expression that is not in its release phase."""
        return next((e.name for e in reversed(self.running) if e.released_at > now), None)

    def set_unit(self, unit: int, intensity: float) -> "ExpressionState":
        """Set the intensity of an action unit, 0 to 1."""
        units = {**self.units, unit: intensity}
        return replace(self, units={number: value for number, value in units.items() if value})

    def at(self, now: float) -> NDArray[np.float32]:
        """Return the summed (n, 3) displacements, FAPU units, of action units and expressions, without idle motion."""
        total = combine_action_units(self.units) if self.units else np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
        for expression in self.running:
            total += expression.at(now)
        return total
