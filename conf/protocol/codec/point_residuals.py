"""Which points leave the learned space so far that they are sent one by one: a grimace nobody was trained on.

Strategy. The components carry what faces usually do. What they cannot carry of a motion is its *residual*; where that
moves a point visibly, a correction of the point follows, the worst first, as many as the frame's budget has room for.
Points that count more for a viewer have finer steps, so they come first. Corrections are part of the frame: once it is
acknowledged, later frames keep them for nothing and the room goes to the next points. That is also why a frame without
a reference sends only what is far off: it will not be kept.
"""

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.quantised_frame import PointResidual
from conf.protocol.codec.symbol_coder import LIMIT
from conf.protocol.codec.syntax import MAX_RESIDUALS

PointResiduals = dict[int, PointResidual]

MIN_RESIDUAL = 2.5  # steps: a point that is off by less is never corrected
MIN_RESIDUAL_INTRA = 4.0  # the same where there is no reference
BITS_PER_RESIDUAL = 18  # what one costs, about


def choose_point_residuals(
    model: CodecModel, displacements: NDArray[np.float32], known: PointResiduals, *, threshold: float, bits_spent: float
) -> PointResiduals:
    """Return the corrections that improve a frame most, the worst point first; most frames need none.

    displacements : (n, 3) FAPU units, what is to be shown
    known : the reference's corrections
    threshold : steps that a point must be off
    bits_spent : of the frame's budget; there is room for one correction at least
    """
    residual = model.transform.residual(displacements)
    missing = residual.copy()
    for point, steps in known.items():
        missing[point] -= steps
    size = np.sqrt(np.einsum("ij,ij->i", missing, missing))
    if size.max() <= threshold:
        return {}
    worst = np.argsort(-size, kind="stable")[: _room(model, bits_spent)]
    chosen: PointResiduals = {}
    for point in worst[size[worst] > threshold].tolist():
        x, y, z = np.rint(np.clip(residual[point], -LIMIT, LIMIT)).astype(int).tolist()
        chosen[point] = (x, y, z)
    return chosen


def _room(model: CodecModel, bits_spent: float) -> int:
    room = int(model.profile.target_bits - bits_spent) // BITS_PER_RESIDUAL
    return max(1, min(MAX_RESIDUALS, room))
