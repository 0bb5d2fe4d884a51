"""What a face does over time, as nine curves: the measure of a true picture.

All lengths are taken with the head pose removed and divided by the distance of the outer eye corners (landmarks 33 and
263), angles are in degrees.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose

EYE_CORNERS = (33, 263)
PAIRS = {
    "mouth_opening": [(13, 14)],
    "mouth_width": [(61, 291)],
    "lid_right": [(159, 145)],
    "lid_left": [(386, 374)],
    "brow_inner": [(107, 133), (336, 362)],
    "brow_outer": [(105, 33), (334, 263)],
}
ANGLES = ("yaw", "pitch", "roll")
CURVES = (*PAIRS, *ANGLES)


def face_curves(aligned: NDArray[np.floating], pose: HeadPose, /) -> dict[str, float]:
    """Return one value for each of CURVES.

    aligned : (478, 3) landmarks with the head pose removed, any length unit
    """
    unit = float(np.linalg.norm(aligned[EYE_CORNERS[0]] - aligned[EYE_CORNERS[1]]))
    lengths = {name: _gap(aligned, pairs) / unit for name, pairs in PAIRS.items()}
    return lengths | dict(zip(ANGLES, pose.yaw_pitch_roll(), strict=True))


def _gap(aligned: NDArray[np.floating], pairs: list[tuple[int, int]]) -> float:
    """Mean distance in the picture's plane: depth from one camera is a guess."""
    return float(np.mean([np.linalg.norm(aligned[a, :2] - aligned[b, :2]) for a, b in pairs]))


def compare(source: NDArray[np.floating], shown: NDArray[np.floating], /) -> tuple[float, float]:
    """Return correlation and gain (slope of shown over source by least squares).

    source, shown : (N,) one curve on the person and on the drawing. A curve that does not move has neither: NaN.
    """
    a, b = source - source.mean(), shown - shown.mean()
    energy, shown_energy = float(a @ a), float(b @ b)
    if energy < 1e-9 or shown_energy < 1e-9:
        return float("nan"), float("nan")
    cross = float(a @ b)
    return cross / np.sqrt(energy * shown_energy), cross / energy
