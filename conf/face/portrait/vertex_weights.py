"""Weights of the vertices of a photo's mesh: how far they follow the head pose."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.photo_mesh import border_extension
from conf.face.portrait.photographed_face import PhotographedFace

SHOULDER_WEIGHTS = (0.35, 0.0)  # sideways, and up or down: people sway with their shoulders, but nod without them
NECK_CM = 9.0  # length of the transition from head to shoulders
BELOW_CHIN_CM = 0.5  # where it begins
HAIR_FALLOFF = (1.7, 3.0)  # of half the oval's width: hair nearer than that follows the head, farther the shoulders
BORDER = 0.15  # image heights over which the shoulders' weight falls to 0 at the border


def head_weights(
    positions_cm: NDArray[np.float64], positions: NDArray[np.float64], face: PhotographedFace, /
) -> NDArray[np.float64]:
    """Return (V, 2) skinning weights for motion sideways and up or down: 1 for the head, 0 for the lower border."""
    chin = CONTROL_POINT_INDEX["chin_bottom"]
    upright = face.upright(positions_cm)
    centre = upright[OVAL_ROWS].mean(axis=0)
    half_width = float(np.ptp(upright[OVAL_ROWS, 0])) / 2
    below = upright[chin, 1] - BELOW_CHIN_CM - upright[:, 1]
    beside = np.abs(upright[:, 0] - centre[0]) / half_width
    beside = (beside - HAIR_FALLOFF[0]) / (HAIR_FALLOFF[1] - HAIR_FALLOFF[0])
    body = np.maximum(smoothstep(below / NECK_CM), smoothstep(beside))
    above_bottom = positions[:, 1] + 0.5
    # With the chin near the border there is no space for the neck: fix the end of the extension, not the border.
    above_bottom += np.clip(BORDER / 0.9 - above_bottom[chin], 0, border_extension(face))
    space = float(np.clip(0.9 * above_bottom[chin], 1e-3, BORDER))
    body = np.maximum(body, 1 - smoothstep(above_bottom / space))
    to_border = np.minimum(above_bottom, face.aspect / 2 - np.abs(positions[:, 0]))
    body, inside = body[:, None], smoothstep(to_border / BORDER)[:, None]
    return np.asarray((1 - body) + body * inside * SHOULDER_WEIGHTS)
