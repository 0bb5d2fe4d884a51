"""Nine curves over time that describe a face, to compare a drawing with the person.

Lengths are measured with the head pose removed and divided by the distance of the outer eye corners (landmarks 33 and
263); angles are in degrees.
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
    """Return the mean distance in the image plane; depth from one camera is too inaccurate."""
    return float(np.mean([np.linalg.norm(aligned[a, :2] - aligned[b, :2]) for a, b in pairs]))


def compare(source: NDArray[np.floating], shown: NDArray[np.floating], /) -> tuple[float, float]:
    """Return correlation and gain (slope of shown over source by least squares).

    source, shown : (N,) one curve of the person and of the drawing. Both results are NaN for a constant curve.
    """
    a, b = source - source.mean(), shown - shown.mean()
    energy, shown_energy = float(a @ a), float(b @ b)
    if energy < 1e-9 or shown_energy < 1e-9:
        return float("nan"), float("nan")
    cross = float(a @ b)
    return cross / np.sqrt(energy * shown_energy), cross / energy
