"""Choose the points whose motion the learned space cannot represent: a grimace outside the training data.

Strategy. The components of the learned space carry usual motion. What they cannot carry is the residual. Where it moves
a point visibly, the point's residual is sent, the largest first, as many as the frame's bit budget allows. Important
points have finer steps, so they come first. Residuals are part of the frame: after the frame is acknowledged, later
frames keep them at no cost and the budget goes to the next points. A frame without reference is not kept, so it sends
only large residuals.
"""

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.reference_frames import PointResidual
from conf.protocol.codec.symbol_coder import LIMIT
from conf.protocol.codec.syntax import MAX_RESIDUALS

PointResiduals = dict[int, PointResidual]

MIN_RESIDUAL = 2.5  # steps: a smaller error of a point is never corrected
MIN_RESIDUAL_INTRA = 4.0  # steps: the same without a reference
BITS_PER_RESIDUAL = 18  # approximate cost


def choose_point_residuals(
    model: CodecModel, displacements: NDArray[np.float32], known: PointResiduals, *, threshold: float, bits_spent: float
) -> PointResiduals:
    """Return the residuals that improve a frame, the largest error first; usually none.

    displacements : (n, 3) FAPU units, the motion to be coded
    known : the reference's residuals
    threshold : minimum error of a point, steps
    bits_spent : of the frame's budget; one residual always fits
    """
    residual = model.transform.residual(displacements)
    missing = residual.copy()
    for point, steps in known.items():
        missing[point] -= steps
    error = np.sqrt(np.einsum("ij,ij->i", missing, missing))
    if error.max() <= threshold:
        return {}
    room = int(model.profile.target_bits - bits_spent) // BITS_PER_RESIDUAL
    largest = np.argsort(-error, kind="stable")[: max(1, min(MAX_RESIDUALS, room))]
    chosen: PointResiduals = {}
    for point in largest[error[largest] > threshold].tolist():
        x, y, z = np.rint(np.clip(residual[point], -LIMIT, LIMIT)).astype(int).tolist()
        chosen[point] = (x, y, z)
    return chosen
