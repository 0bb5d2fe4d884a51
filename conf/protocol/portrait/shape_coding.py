"""The points, the neutral pose and the person's outline of a photo as a range-coded string."""

import numpy as np

from conf.protocol.codec.symbol_coder import SymbolCoder, SymbolReader, SymbolWriter
from conf.protocol.portrait.probability_model import PortraitModel, Steps, code_numbers

POINT_STEP = 0.02  # cm: 0.2 % of the eye distance
OUTLINE_STEPS = 255  # from one border of the image to the other
_OUTLINE_SCALE = 28  # of the difference between consecutive outline points: nine steps


def encode_shape(points: Steps, neutral: Steps, outline: Steps, model: PortraitModel, /) -> bytes:
    """Return the string of a photo's shape.

    points (D, 3), neutral (n, 3) : steps of POINT_STEP; outline (K, 2) : steps of 1 / OUTLINE_STEPS
    """
    writer = SymbolWriter(rd_lambda=0)
    _code_shape(writer, model, (points, neutral, outline))
    return writer.finish()


def decode_shape(data: bytes, outline_points: int, model: PortraitModel, /) -> tuple[Steps, Steps, Steps]:
    """Return points, neutral pose and outline as in encode_shape. Raises ProtocolError."""
    reader = SymbolReader(data)
    outline = np.zeros((outline_points, 2), np.int64)
    shape = np.zeros_like(model.face.mean), np.zeros_like(model.neutral_difference_scale), outline
    shape = _code_shape(reader, model, shape)
    reader.finish()
    return shape


def encode_neutral_shape(neutral: Steps, model: PortraitModel, /) -> bytes:
    """Return the string of a neutral pose (n, 3), steps of POINT_STEP."""
    writer = SymbolWriter(rd_lambda=0)
    model.face.code(writer, neutral)
    return writer.finish()


def decode_neutral_shape(data: bytes, model: PortraitModel, /) -> Steps:
    """Return the neutral pose (n, 3), steps of POINT_STEP. Raises ProtocolError."""
    reader = SymbolReader(data)
    neutral = model.face.code(reader, np.zeros_like(model.neutral_difference_scale))
    reader.finish()
    return neutral


def _code_shape(
    coder: SymbolCoder, model: PortraitModel, shape: tuple[Steps, Steps, Steps]
) -> tuple[Steps, Steps, Steps]:
    points, neutral, outline = shape
    points = model.face.code(coder, points)
    control_points = points[: len(neutral)]
    difference = code_numbers(coder, model.neutral_difference_scale, neutral - control_points)
    sides = np.diff(outline, axis=0, prepend=0)
    sides = code_numbers(coder, np.full_like(sides, _OUTLINE_SCALE), sides)
    return points, control_points + difference, np.cumsum(sides, axis=0)
