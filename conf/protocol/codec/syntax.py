"""The order of symbols in a payload, written once for both directions.

Strategy. Each function takes a coder. A Writer writes what is wanted and gives back what it wrote; a Reader ignores
what is wanted and gives back what it read. So the two sides cannot disagree about the order, and everything that is
computed from what the coder gave back, prediction and contexts, is the same on both.

A value is sent as its difference from the reference frame's. How large the difference is likely to be depends on the
value, on the reference's age, on what has already been sent of this frame (a face that began to move moves on), on how
much the reference itself was away from neutral, and, when the frame before the reference is known as well, on how much
moved between those two. Logarithms of these are the features; the trained weights turn them into a scale.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from conf.errors import ProtocolError
from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.quantised_frame import FACE_CENTRE, LOG_SCALE, POSE_VALUES, PointResidual, QuantisedFrame
from conf.protocol.codec.symbol_coder import LIMIT, SymbolCoder, uniform_table, weighted_table

LOG_ONE = 16  # a feature's logarithm to base two counts in sixteenths
FEATURE_COUNT = 8
_LOG_REACH = 1023
_LOG: list[int] = [
    ((1 + x) ** LOG_ONE).bit_length() - 1 for x in range(_LOG_REACH + 1)
]  # floor(16 log2(1 + x)), in whole numbers

RESIDUAL_SCALE = 24
MAX_RESIDUALS = 12
_CORRECTION_COUNT = weighted_table([3000, 12, 10, 8, 6, 4, 4, 3, 2, 2, 2, 1, 1])


@dataclass(frozen=True)
class Context:
    """What a frame is predicted from: a row of the weights, a reference, and perhaps the frame before that."""

    row: int
    reference: QuantisedFrame
    second_reference: QuantisedFrame | None = None


class FrameCoder:
    """Codes the values of one frame in order; `values` holds those that have been coded."""

    def __init__(self, coder: SymbolCoder, model: CodecModel, context: Context) -> None:
        self.values: list[int] = []
        self._coder = coder
        self._model = model
        self._row = context.row
        self._predicted = context.reference.values
        self._still = _frame_features(context)
        self._own = _own_motion(context)
        self._moved = [0, 0]  # sum of the differences so far, of pose and of expression

    def code(self, wanted: Sequence[float]) -> None:
        """Code the next len(wanted) values. Raises ProtocolError, when reading, if one is out of range."""
        coder, model, values, moved = self._coder, self._model, self.values, self._moved
        for target in wanted:
            index = len(values)
            size = values[LOG_SCALE] if values else 0
            features = (LOG_ONE, size, _log(moved[0]), _log(moved[1]), self._own[index], *self._still)
            scale = model.scale(self._row, index, features)
            guess = self._guess(index)
            difference = coder.number(model.tables, scale, target - guess)
            moved[index >= POSE_VALUES] += abs(difference)
            values.append(_checked(guess + difference))

    def _guess(self, index: int) -> int:
        guess = self._predicted[index]
        if (
            FACE_CENTRE.start <= index < FACE_CENTRE.stop
        ):  # in a face that has grown the same place is fewer face sizes away
            guess -= guess * (self.values[LOG_SCALE] - self._predicted[LOG_SCALE]) * self._model.scale_coupling >> 16
        return max(-LIMIT, min(LIMIT, guess))


def code_point_residuals(
    coder: SymbolCoder, model: CodecModel, reference: dict[int, PointResidual], wanted: dict[int, PointResidual]
) -> dict[int, PointResidual]:
    """Code the corrections that change; the reference's others stay. Raises ProtocolError as above."""
    corrections = dict(reference)
    changed = list(wanted)
    for position in range(coder.symbol(_CORRECTION_COUNT, len(changed))):
        point = coder.symbol(uniform_table(model.points), changed[position] if changed else 0)
        before = reference.get(point, (0, 0, 0))
        after = wanted.get(point, (0, 0, 0))
        x, y, z = (
            _checked(b + coder.number(model.tables, RESIDUAL_SCALE, a - b)) for a, b in zip(after, before, strict=True)
        )
        corrections.pop(point, None)
        if x or y or z:
            corrections[point] = (x, y, z)
    return corrections


def _frame_features(context: Context) -> tuple[int, int, int]:
    expression = _log(sum(map(abs, context.reference.values[POSE_VALUES:])))
    if context.second_reference is None:
        return expression, 0, 0
    motion = [abs(a - b) for a, b in zip(context.reference.values, context.second_reference.values, strict=True)]
    return expression, _log(sum(motion[:POSE_VALUES])), _log(sum(motion[POSE_VALUES:]))


def _own_motion(context: Context) -> list[int]:
    if context.second_reference is None:
        return [0] * len(context.reference.values)
    return [_log(abs(a - b)) for a, b in zip(context.reference.values, context.second_reference.values, strict=True)]


def _log(magnitude: int) -> int:
    return _LOG[min(magnitude, _LOG_REACH)]


def _checked(value: int) -> int:
    if not -LIMIT <= value <= LIMIT:
        raise ProtocolError("a value out of range")
    return value
