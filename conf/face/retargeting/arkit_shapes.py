"""The 52 sculpted shapes of the shipped head, seen at its control points: what each does in FAPU units.

A sculpted gaze shape moves the lids alone, for the head's eyeballs are turned by their pupils: here the pupils move
with it.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.animation.gaze import EYE_RADIUS
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.loading import load_face

FULL_GAZE = {"Up": (0, 1, 22.0), "Down": (0, -1, 28.0), "In": (-1, 0, 30.0), "Out": (1, 0, 30.0)}  # left eye, degrees


@cache
def load_arkit_shapes() -> dict[str, NDArray[np.float32]]:
    """Return the (n, 3) displacements, FAPU units, of each shape by its ARKit name, at full strength.

    Raises FileFormatError if an asset is missing or damaged.
    """
    face = load_face()
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(face.mesh.vertices))
    nearest = np.asarray(KDTree(face.mesh.vertices).query(face.control_points)[1])
    displacements = (shapes.offsets[:, nearest] / face.fapu.lengths()).astype(np.float32)
    for name, displacement in zip(shapes.names, displacements, strict=True):
        _turn_pupil(name, displacement)
    return dict(zip(shapes.names, displacements, strict=True))


def _turn_pupil(name: str, displacement: NDArray[np.float32]) -> None:
    """Move the pupil of one eye in place, if the shape is one of gaze: `eyeLookInLeft`."""
    for direction, (x, y, degrees) in FULL_GAZE.items():
        for side, mirror in (("Left", 1), ("Right", -1)):
            if name == f"eyeLook{direction}{side}":
                travel = EYE_RADIUS * np.sin(np.radians(degrees))
                displacement[CONTROL_POINT_INDEX[f"pupil_{side[0].lower()}"]] = [x * mirror * travel, y * travel, 0.0]
