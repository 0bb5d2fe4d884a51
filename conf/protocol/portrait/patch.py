"""A patch as it travels: how one region of the face differs from the photograph, and the moment it belongs to.

photograph u8, region u8, slot u8, then one range-coded string: keys, points, width, height, step, blocks.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.codec.symbol_coder import SymbolCoder, SymbolReader, SymbolWriter, uniform_table
from conf.protocol.portrait.dct_coding import Planes, code_coefficient_planes, plane_shapes
from conf.protocol.portrait.probability_model import PortraitModel, Steps, code_numbers, load_portrait_model

MAX_SLOTS = 16  # of each region
MAX_SIDE = 96  # px
POINT_STEPS = 127.5  # from one border of the patch to the other
STEP_COUNT = 48
STEPS_AN_OCTAVE = 8  # of the quantiser's step
MIN_STEP = 3.0  # levels of brightness, in an orthonormal transform
RD_LAMBDA = 0.12  # squared error, in steps, for a bit
_HEAD = 3  # bytes
_SIDES, _STEPS = uniform_table(MAX_SIDE), uniform_table(STEP_COUNT)


@dataclass(frozen=True)
class Patch:
    """What is to be added to the photograph in a region of the face.

    photograph : number of the photograph that it is laid over
    region : which part of the face
    slot : it replaces what the slot of its region held
    keys : (k,) what the face was doing: the receiver shows the patch whose keys are nearest
    points : (m, 2) the region's control points: 0 to 1 from the patch's upper left corner, or beyond
    size : width and height in pixels
    step : which of STEP_COUNT quantiser steps, the finest first
    planes : blocks of coefficients of brightness and two tints, in steps; whole numbers once they have travelled
    """

    photo_number: int
    region: int
    slot: int
    descriptor: NDArray[np.int8]
    points: NDArray[np.float64]
    size: tuple[int, int]
    step: int
    coefficients: Planes


def step_size(step: int, /) -> float:
    """Return how large a step is, levels of brightness."""
    return float(MIN_STEP * 2 ** (step / STEPS_AN_OCTAVE))


def encode_patch(patch: Patch, /, *, model: PortraitModel | None = None) -> bytes:
    """Return the bytes of a patch, by the shipped model if none is given. Raises ValueError if it cannot travel."""
    model = model or load_portrait_model()
    if not 0 <= patch.region < len(model.regions) or not 0 <= patch.slot < MAX_SLOTS:
        raise ValueError(f"there is no region {patch.region} with a slot {patch.slot}")
    points = np.rint(patch.points * POINT_STEPS).astype(np.int64)
    writer = SymbolWriter(rd_lambda=RD_LAMBDA)
    _code(
        writer,
        model,
        (patch.region, patch.descriptor.astype(np.int64), points, patch.size, patch.step, patch.coefficients),
    )
    return bytes((patch.photo_number, patch.region, patch.slot)) + writer.finish()


def decode_patch(data: bytes, /) -> Patch:
    """Return the patch. Raises ProtocolError."""
    if len(data) < _HEAD:
        raise ProtocolError("a patch cut off")
    photograph, region, slot = data[:_HEAD]
    model = load_portrait_model()
    if region >= len(model.regions) or slot >= MAX_SLOTS:
        raise ProtocolError("a patch for no region or slot")
    known = model.regions[region]
    reader = SymbolReader(data[_HEAD:])
    nothing = (region, np.zeros_like(known.descriptor_scale), np.zeros_like(known.points.mean), (0, 0), 0, None)
    keys, points, size, step, planes = _code(reader, model, nothing)
    reader.finish()
    if np.abs(keys).max() > 127 or np.abs(points).max() > 2 * POINT_STEPS:
        raise ProtocolError("a patch far from the face")
    return Patch(photograph, region, slot, keys.astype(np.int8), points / POINT_STEPS, size, step, planes)


_Wanted = tuple[int, Steps, Steps, tuple[int, int], int, Planes | None]


def _code(
    coder: SymbolCoder, model: PortraitModel, wanted: _Wanted
) -> tuple[Steps, Steps, tuple[int, int], int, Planes]:
    region, keys, points, (width, height), step, planes = wanted
    known = model.regions[region]
    keys = code_numbers(coder, known.descriptor_scale, keys)
    points = known.points.code(coder, points)
    width, height = (coder.symbol(_SIDES, side - 1) + 1 for side in (width, height))
    step = coder.symbol(_STEPS, step)
    if planes is None:
        planes = [np.zeros(shape, np.int64) for shape in plane_shapes(width, height)]
    return keys, points, (width, height), step, code_coefficient_planes(coder, model.blocks, planes)
