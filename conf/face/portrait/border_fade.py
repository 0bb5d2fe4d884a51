"""Opacity of the person beyond the photo's border: a cut-off head is continued as a dome, all else fades.

Beyond the border there are only the colours at the border. They suit the missing part of a head. Farther away they must
fade, or the person would end in a straight edge when the head moves away from the border.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.face.portrait.photographed_face import PhotographedFace

HEAD_ELLIPSE = (0.62, 0.75)  # semi-axes of the head, of the width and height of the face's oval
HEAD_OFFSET = 0.12  # of the oval's height: the head's centre above the oval's
FADE = (0.85, 1.2)  # of the ellipse's radius: the head fades between them
END = 0.6  # of BORDER_EXTENSION: the outer part over which the head fades in any case


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
