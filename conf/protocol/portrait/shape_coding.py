"""The numbers of a photograph in few bytes: where its points lie, the neutral pose, the person's outline."""

import numpy as np

from conf.protocol.codec.symbol_coder import SymbolCoder, SymbolReader, SymbolWriter
from conf.protocol.portrait.probability_model import PortraitModel, Steps, code_numbers

POINT_STEP = 0.02  # cm: a fifth of a per cent of the eye distance
OUTLINE_STEPS = 255  # from one border of the picture to the other
_CORNER_SPREAD = 28  # the scale of what lies between two corners: nine steps


def encode_shape(points: Steps, neutral: Steps, outline: Steps, model: PortraitModel, /) -> bytes:
    """Return the bytes of a photograph's numbers.

    points (D, 3), neutral (n, 3) : steps of POINT_STEP; outline (K, 2) : steps of 1 / OUTLINE_STEPS
    """
    writer = SymbolWriter(rd_lambda=0)
    _code_shape(writer, model, (points, neutral, outline))
    return writer.finish()


def decode_shape(data: bytes, outline_points: int, model: PortraitModel, /) -> tuple[Steps, Steps, Steps]:
    """Return points, neutral pose and outline of `corners` corners. Raises ProtocolError."""
    reader = SymbolReader(data)
    nothing = (
        np.zeros_like(model.face.mean),
        np.zeros_like(model.neutral_difference_scale),
        np.zeros((outline_points, 2), np.int64),
    )
    found = _code_shape(reader, model, nothing)
    reader.finish()
    return found


def encode_neutral_shape(neutral: Steps, model: PortraitModel, /) -> bytes:
    """Return the bytes of a neutral pose (n, 3), steps of POINT_STEP."""
    writer = SymbolWriter(rd_lambda=0)
    model.face.code(writer, neutral)
    return writer.finish()


def decode_neutral_shape(data: bytes, model: PortraitModel, /) -> Steps:
    """Return the neutral pose (n, 3). Raises ProtocolError."""
    reader = SymbolReader(data)
    neutral = model.face.code(reader, np.zeros_like(model.neutral_difference_scale))
    reader.finish()
    return neutral


def _code_shape(
    coder: SymbolCoder, model: PortraitModel, wanted: tuple[Steps, Steps, Steps]
) -> tuple[Steps, Steps, Steps]:
    points, neutral, outline = wanted
    told = model.face.code(coder, points)
    controls = told[: len(neutral)]
    stir = code_numbers(coder, model.neutral_difference_scale, neutral - controls)
    sides = np.diff(outline, axis=0, prepend=0)
    told_sides = code_numbers(coder, np.full_like(sides, _CORNER_SPREAD), sides)
    return told, controls + stir, np.cumsum(told_sides, axis=0)
