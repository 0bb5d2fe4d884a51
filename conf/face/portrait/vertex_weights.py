"""Weights of the vertices of a photo's mesh: how far they follow the head pose, and the person's opacity.

Beyond the photo's border there are only the colours at the border. They suit the missing part of a head. Farther away
they must fade, or the person would end in a straight edge when the head moves away from the border.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.photo_mesh import BORDER_EXTENSION
from conf.face.portrait.photographed_face import PhotographedFace

SHOULDER_WEIGHT = 0.35
NECK_CM = 9.0  # length of the transition from head to shoulders
BELOW_CHIN_CM = 0.5  # where it begins
HAIR_FALLOFF = (1.7, 3.0)  # of half the oval's width: hair nearer than that follows the head, farther the shoulders
BORDER = 0.15  # image heights over which the shoulders' weight falls to 0 at the border
HEAD_ELLIPSE = (0.62, 0.75)  # semi-axes of the head, of the width and height of the face's oval
HEAD_OFFSET = 0.12  # of the oval's height: the head's centre above the oval's
FADE = (0.85, 1.2)  # of the ellipse's radius: the head fades between them
END = 0.6  # of BORDER_EXTENSION: the outer part over which the head fades in any case


def head_weights(
    positions_cm: NDArray[np.float64], positions: NDArray[np.float64], face: PhotographedFace, /
) -> NDArray[np.float64]:
    """Return (V,) skinning weights: 1 for the head, less for the shoulders, 0 for the lower border, which is fixed."""
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
    above_bottom += np.clip(BORDER / 0.9 - above_bottom[chin], 0, BORDER_EXTENSION)
    space = float(np.clip(0.9 * above_bottom[chin], 1e-3, BORDER))
    body = np.maximum(body, 1 - smoothstep(above_bottom / space))
    to_border = np.minimum(above_bottom, face.aspect / 2 - np.abs(positions[:, 0]))
    return np.asarray((1 - body) + body * (SHOULDER_WEIGHT * smoothstep(to_border / BORDER)))


def border_alpha(
    positions_cm: NDArray[np.float64], positions: NDArray[np.float64], face: PhotographedFace, /
) -> NDArray[np.float64]:
    """Return (V,), 0 to 1: the opacity of the person at each vertex; 1 inside the photo and below the chin."""
    upright = face.upright(positions_cm)
    low, high = upright[OVAL_ROWS].min(axis=0), upright[OVAL_ROWS].max(axis=0)
    size = high - low
    offset = upright - (low + high) / 2 - (0.0, HEAD_OFFSET * size[1])
    radius = np.linalg.norm(offset / (size * HEAD_ELLIPSE), axis=1)
    t = (FADE[1] - radius) / (FADE[1] - FADE[0])
    outside = np.max(np.abs(positions) - (face.aspect / 2, 0.5), axis=1)
    t = np.minimum(t, (BORDER_EXTENSION - outside) / (END * BORDER_EXTENSION))
    fades = (outside > 1e-9) & (upright[:, 1] > upright[CONTROL_POINT_INDEX["chin_bottom"], 1])
    return np.asarray(np.where(fades, smoothstep(t), 1.0))
