"""The canonical face, a mean face that head pose is measured against, and the removal of the head pose from landmarks.

Source: MediaPipe, geometry_pipeline_metadata_landmarks.binarypb in the bundle of the face landmarker.
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.rotations import rotation_vector
from conf.face.similarity import fit_similarity

FLIP = np.array([1.0, -1.0, -1.0])  # from the tracker's axes (y down, z away) to the face's (y up, z to the viewer)


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


def remove_head_pose(
    landmarks: NDArray[np.floating], canonical: CanonicalFace, size: tuple[int, int], /
) -> tuple[NDArray[np.float64], HeadPose]:
    """Align landmarks with the canonical face.

    landmarks : (478, 3) px, x right, y down, z away from the camera
    size : width and height of the image, px
    Returns the landmarks (478, 3), cm in face axes, and the head pose.
    """
    points = np.asarray(landmarks, dtype=np.float64) * FLIP
    fit = fit_similarity(canonical.vertices[canonical.rigid], points[canonical.rigid], canonical.weights)
    aligned = (points - fit.translation) @ fit.rotation / fit.scale
    width, height = size
    position = (fit.translation[:2] - np.array([width, -height]) / 2) / height
    return aligned, HeadPose(rotation_vector(fit.rotation), position, float(np.log(fit.scale / height)))
