"""The order of symbols of a frame, and the prediction of its values, written once for both directions.

Strategy. Each function takes a coder. A writer writes the value passed to it and returns what it wrote; a reader
ignores the value and returns what it read. Predictions and contexts are computed from what the coder returned, so they
are the same on both sides.

The first frame of a payload is predicted from acknowledged frames, each other frame from the one before it, which
arrives in the same datagram or not at all. A value is coded as its difference from the reference frame's. The expected
size of the difference depends on the value, on the reference's age, on the differences already coded in this frame
(motion continues), on the reference's distance from neutral and, with a second reference, on the motion between the two
references. Logarithms of these are the features; the trained weights turn them into a scale.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from conf.errors import ProtocolError
from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.payload_header import PayloadHeader
from conf.protocol.codec.reference_frames import FACE_CENTRE, LOG_SCALE, POSE_VALUES, PointResidual, QuantisedFrame
from conf.protocol.codec.symbol_coder import LIMIT, SymbolCoder, uniform_table, weighted_table

LOG_ONE = 16  # features are in units of 1/16 octave
FEATURE_COUNT = 8
_MAX_LOG_INPUT = 1023
# floor(16 log2(1 + x)) in integer arithmetic, equal on every machine.
_LOG: list[int] = [((1 + x) ** LOG_ONE).bit_length() - 1 for x in range(_MAX_LOG_INPUT + 1)]

RESIDUAL_SCALE = 24
MAX_RESIDUALS = 12
_RESIDUAL_COUNT = weighted_table([3000, 12, 10, 8, 6, 4, 4, 3, 2, 2, 2, 1, 1])


@dataclass(frozen=True)
class Context:
    """What a frame is predicted from: a row of the context weights and one or two references.

    The features that follow from these are the same for each attempt of the encoder.
    """

    row: int
    reference: QuantisedFrame
    second_reference: QuantisedFrame | None = None

    @cached_property
    def motion_features(self) -> list[int]:
        """For each value, how far it moved between the references."""
        return [_log(distance) for distance in self._motion]

    @cached_property
    def frame_features(self) -> tuple[int, int, int]:
        """The reference's distance from neutral, and the motion of pose and of components between the references."""
        motion = self._motion
        return (
            _log(sum(map(abs, self.reference.values[POSE_VALUES:]))),
            _log(sum(motion[:POSE_VALUES])),
            _log(sum(motion[POSE_VALUES:])),
        )

    @cached_property
    def _motion(self) -> list[int]:
        if self.second_reference is None:
            return [0] * len(self.reference.values)
        return [abs(a - b) for a, b in zip(self.reference.values, self.second_reference.values, strict=True)]


def first_context(
    model: CodecModel, header: PayloadHeader, frame_number: int, require: Callable[[int], QuantisedFrame]
) -> Context:
    """Return the context of frame `frame_number`, the first of a payload. require : returns a frame by number"""
    if not header.age:
        return Context(model.rows[0], replace(model.default_reference, staggered=header.is_staggered(frame_number)))
    number = frame_number - header.age
    if header.second_reference:
        return Context(model.second_reference_rows[header.age], require(number), require(number - header.stride))
    return Context(model.rows[header.age], require(number))


def next_context(model: CodecModel, header: PayloadHeader, coded: Sequence[QuantisedFrame]) -> Context:
    """Return the context of the frame after those already coded of a payload."""
    if len(coded) > 1:
        return Context(model.second_reference_rows[header.stride], coded[-1], coded[-2])
    return Context(model.rows[header.stride], coded[-1])


class FrameCoder:
    """Code the values of one frame in order. values : those coded so far"""

    def __init__(self, coder: SymbolCoder, model: CodecModel, context: Context) -> None:
        self.values: list[int] = []
        self._coder = coder
        self._model = model
        self._row = context.row
        self._reference = context.reference.values
        self._motion_features, self._frame_features = context.motion_features, context.frame_features
        self._coded_motion = [0, 0]  # sums of the differences so far, of pose and of components

    def code(self, targets: Sequence[float]) -> None:
        """Code the next len(targets) values. Raises ProtocolError when a value read is out of range."""
        coder, model, values, coded_motion = self._coder, self._model, self.values, self._coded_motion
        logs = [_log(distance) for distance in coded_motion]
        for index, target in enumerate(targets, len(values)):
            size = values[LOG_SCALE] if values else 0
            features = (LOG_ONE, size, *logs, self._motion_features[index], *self._frame_features)
            scale = model.scale(self._row, index, features)
            in_face_sizes = FACE_CENTRE.start <= index < FACE_CENTRE.stop
            prediction = self._face_centre(index) if in_face_sizes else self._reference[index]
            difference = coder.number(model.tables, scale, target - prediction)
            if difference:
                part = index >= POSE_VALUES
                coded_motion[part] += abs(difference)
                logs[part] = _log(coded_motion[part])
            values.append(_checked(prediction + difference))

    def _face_centre(self, index: int) -> int:
        """Return the prediction of a coordinate that is measured in face sizes: it shrinks when the face grows."""
        value = self._reference[index]
        value -= value * (self.values[LOG_SCALE] - self._reference[LOG_SCALE]) * self._model.scale_coupling >> 16
        return max(-LIMIT, min(LIMIT, value))


def code_point_residuals(
    coder: SymbolCoder, model: CodecModel, reference: dict[int, PointResidual], changes: dict[int, PointResidual]
) -> dict[int, PointResidual]:
    """Code the residuals that change and return all of the frame; the reference's others stay. Raises ProtocolError."""
    residuals = dict(reference)
    points = list(changes)
    for position in range(coder.symbol(_RESIDUAL_COUNT, len(points))):
        point = coder.symbol(uniform_table(model.points), points[position] if points else 0)
        before = reference.get(point, (0, 0, 0))
        after = changes.get(point, (0, 0, 0))
        x, y, z = (
            _checked(b + coder.number(model.tables, RESIDUAL_SCALE, a - b)) for a, b in zip(after, before, strict=True)
        )
        residuals.pop(point, None)
        if x or y or z:
            residuals[point] = (x, y, z)
    return residuals


def _log(magnitude: int) -> int:
    return _LOG[min(magnitude, _MAX_LOG_INPUT)]


def _checked(value: int) -> int:
    if not -LIMIT <= value <= LIMIT:
        raise ProtocolError("a value out of range")
    return value
