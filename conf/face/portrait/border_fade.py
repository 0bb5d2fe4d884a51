"""What a photograph's border cut off: a head goes on as a dome, what is beside it fades away.

The colours at the border are all there is to go on with. A crown that a head lacks may have them, softened; what is
farther fades, or it would end in a straight edge when the head comes down or in from the side.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours
from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.face.portrait.photographed_face import PhotographedFace

HEAD_ELLIPSE = (
    0.62,
    0.75,
)  # of the face's width to the sides, and of its height above and below: as far as a head goes
HEAD_OFFSET = 0.12  # of the face's height: the head's middle lies above the face's
FADE = (0.85, 1.2)  # of the way to there: between them the head ends
END = 0.6  # of what is drawn beyond the border: over it the head ends in any case

_OVAL = contours.landmark_rows(contours.OVAL)


def border_alpha(
    flat: NDArray[np.float64], places: NDArray[np.float64], shape: PhotographedFace, /
) -> NDArray[np.float64]:
    """Return (V,): how much of the person is shown at each vertex, 1 all, 0 nothing; 1 wherever there is a photograph.

    flat : (V, 2) cm from the face's origin, picture axes; the first D are contours.ALL
    places : (V, 2) the same vertices, picture heights from the picture's centre
    """
    axis = shape.pose.matrix()[:2, 1]
    axis = axis / max(float(np.linalg.norm(axis)), 1e-6)
    upright = flat @ np.array([[axis[1], axis[0]], [-axis[0], axis[1]]])
    low, high = upright[_OVAL].min(axis=0), upright[_OVAL].max(axis=0)
    size = high - low
    away = np.linalg.norm((upright - (low + high) / 2 - (0.0, HEAD_OFFSET * size[1])) / (size * HEAD_ELLIPSE), axis=1)
    t = (FADE[1] - away) / (FADE[1] - FADE[0])
    outside = np.max(np.abs(places) - (shape.aspect / 2, 0.5), axis=1)
    cut_off = outside > 1e-9
    beside_head = cut_off & (upright[:, 1] > upright[CONTROL_POINT_INDEX["chin_bottom"], 1])
    t = np.minimum(t, (BORDER_EXTENSION - outside) / (END * BORDER_EXTENSION))
    return np.asarray(np.where(beside_head, smoothstep(t), 1.0))
