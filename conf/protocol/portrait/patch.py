"""The patch: how one region of the face differs from the photo while the face has a certain expression.

photo number u8, region u8, slot u8, then one range-coded string: descriptor, points, width, height, step, blocks.
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
STEPS_PER_OCTAVE = 8  # of the quantiser step
MIN_STEP = 3.0  # brightness levels, in an orthonormal transform
RD_LAMBDA = 0.12  # squared error, in steps, that saving one bit may cost
_HEADER = 3  # bytes
_SIDES, _STEPS = uniform_table(MAX_SIDE), uniform_table(STEP_COUNT)


@dataclass(frozen=True)
class Patch:
    """What to add to the photo in a region of the face.

    photo_number : of the photo that it belongs to
    region : index of the region of the face
    slot : it replaces the patch in this slot of its region
    descriptor : (k,) the expression of the region: the receiver shows the patch with the nearest descriptor
    points : (m, 2) the region's control points: 0 to 1 from the patch's upper left corner, or outside
    size : width and height in pixels
    step : index of the quantiser step, 0 is the finest
    coefficients : blocks of brightness and two chroma planes, in steps; integers after decoding
    """

    photo_number: int
    region: int
    slot: int
    descriptor: NDArray[np.int8]
    points: NDArray[np.float64]
    size: tuple[int, int]
    step: int
    coefficients: Planes


_Content = tuple[Steps, Steps, tuple[int, int], int, Planes]


def step_size(step: int, /) -> float:
    """Return the size of the quantiser step of an index, brightness levels."""
    return float(MIN_STEP * 2 ** (step / STEPS_PER_OCTAVE))


def encode_patch(patch: Patch, /, *, model: PortraitModel | None = None) -> bytes:
    """Return the bytes of a patch. model : the shipped one if None. Raises ValueError if region or slot is invalid."""
    model = model or load_portrait_model()
    if not 0 <= patch.region < len(model.regions) or not 0 <= patch.slot < MAX_SLOTS:
        raise ValueError(f"there is no region {patch.region} with a slot {patch.slot}")
    points = np.rint(patch.points * POINT_STEPS).astype(np.int64)
    writer = SymbolWriter(rd_lambda=RD_LAMBDA)
    content = patch.descriptor.astype(np.int64), points, patch.size, patch.step, patch.coefficients
    _code(writer, model, patch.region, content)
    return bytes((patch.photo_number, patch.region, patch.slot)) + writer.finish()


def decode_patch(data: bytes, /) -> Patch:
    """Return the patch. Raises ProtocolError."""
    if len(data) < _HEADER:
        raise ProtocolError("a patch cut off")
    photo_number, region, slot = data[:_HEADER]
    model = load_portrait_model()
    if region >= len(model.regions) or slot >= MAX_SLOTS:
        raise ProtocolError("a patch with an invalid region or slot")
    reader = SymbolReader(data[_HEADER:])
    descriptor, points, size, step, planes = _code(reader, model, region)
    reader.finish()
    if np.abs(descriptor).max() > 127 or np.abs(points).max() > 2 * POINT_STEPS:
        raise ProtocolError("a patch far from the face")
    return Patch(photo_number, region, slot, descriptor.astype(np.int8), points / POINT_STEPS, size, step, planes)


def _code(coder: SymbolCoder, model: PortraitModel, region: int, content: _Content | None = None) -> _Content:
    """Code the string of a patch. A reader needs no `content`."""
    scale, tree = model.regions[region].descriptor_scale, model.regions[region].points
    descriptor, points, size, step, planes = content or (np.zeros_like(scale), np.zeros_like(tree.mean), (0, 0), 0, ())
    descriptor = code_numbers(coder, scale, descriptor)
    points = tree.code(coder, points)
    width, height = (coder.symbol(_SIDES, side - 1) + 1 for side in size)
    step = coder.symbol(_STEPS, step)
    planes = planes or [np.zeros(shape, np.int64) for shape in plane_shapes(width, height)]
    return descriptor, points, (width, height), step, code_coefficient_planes(coder, model.blocks, planes)
