"""How much of the head's motion each place of a photograph follows: head all, shoulders a part, border none."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours
from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.face.portrait.photographed_face import PhotographedFace

SHOULDER_WEIGHT = 0.35  # of the head's motion
NECK_CM = 9.0  # below the chin, over which the head's motion turns into the shoulders'
BELOW_CHIN_CM = 0.5
HAIR_FALLOFF = (
    1.7,
    3.0,
)  # of half the face's width: hair still follows the head, what lies beyond does as the shoulders do
BORDER = 0.15  # picture heights, over which the shoulders come to rest at the border

_OVAL = contours.landmark_rows(contours.OVAL)


def head_weights(
    flat: NDArray[np.float64], places: NDArray[np.float64], shape: PhotographedFace, /
) -> NDArray[np.float64]:
    """Return (V,): 1 moves with the head, 0 stays.

    flat : (V, 2) cm from the face's origin, picture axes; the first D are contours.ALL
    places : (V, 2) the same vertices, picture heights from the picture's centre
    """
    axis = shape.pose.matrix()[:2, 1]
    axis = axis / max(float(np.linalg.norm(axis)), 1e-6)  # the head's own up, in the picture
    upright = flat @ np.array([[axis[1], axis[0]], [-axis[0], axis[1]]])
    middle = upright[_OVAL].mean(axis=0)
    half_width = float(np.ptp(upright[_OVAL, 0])) / 2
    below = upright[CONTROL_POINT_INDEX["chin_bottom"], 1] - BELOW_CHIN_CM - upright[:, 1]
    aside = np.abs(upright[:, 0] - middle[0]) / half_width
    loose = np.maximum(
        smoothstep(below / NECK_CM), smoothstep((aside - HAIR_FALLOFF[0]) / (HAIR_FALLOFF[1] - HAIR_FALLOFF[0]))
    )
    above_bottom = places[:, 1] + 0.5
    # With the chin near the border the neck has no room to give: what goes on beyond the border rests, not the border.
    above_bottom += np.clip(BORDER / 0.9 - above_bottom[CONTROL_POINT_INDEX["chin_bottom"]], 0, BORDER_EXTENSION)
    room = float(np.clip(0.9 * above_bottom[CONTROL_POINT_INDEX["chin_bottom"]], 1e-3, BORDER))
    loose = np.maximum(loose, 1 - smoothstep(above_bottom / room))
    to_border = np.minimum(above_bottom, shape.aspect / 2 - np.abs(places[:, 0]))
    body = SHOULDER_WEIGHT * smoothstep(to_border / BORDER)
    return np.asarray((1 - loose) + loose * body)
