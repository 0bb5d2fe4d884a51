"""The canonical face: the mean face that head pose is measured against.

Source: MediaPipe, geometry_pipeline_metadata_landmarks.binarypb in the bundle of the face landmarker.
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class CanonicalFace:
    """A mean face in centimetres: x to the subject's left, y up, z to the viewer; 6.3 cm between the eyes.

    vertices : (468, 3) float64 cm, in the order of the first 468 landmarks
    triangles : (898, 3) int32
    rigid : (33,) int, the landmarks that move little with the expression
    weights : (33,) float64, their weights in the estimation of the head pose
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    rigid: NDArray[np.intp]
    weights: NDArray[np.float64]


@cache
def load_canonical_face() -> CanonicalFace:
    """Return the tracker's canonical face."""
    dtypes = {"vertices": np.float64, "triangles": np.int32, "rigid": np.intp, "weights": np.float64}
    with (files("conf.assets") / "canonical_face.npz").open("rb") as file, np.load(file) as arrays:
        return CanonicalFace(**{name: arrays[name].astype(dtype) for name, dtype in dtypes.items()})
