"""The shipped head's 52 sculpted shapes as motions of the control points."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.animation.gaze import EYE_RADIUS
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.loading import load_face

# Direction (x, y) and angle in degrees of the left eye
FULL_GAZE = {"Up": (0, 1, 22.0), "Down": (0, -1, 28.0), "In": (-1, 0, 30.0), "Out": (1, 0, 30.0)}


@cache
def load_arkit_shapes() -> dict[str, NDArray[np.float32]]:
    """Return the (n, 3) displacements, FAPU units, of each of the head's shapes at weight 1, by ARKit name.

    A sculpted gaze shape moves the lids only, because the head's eyeballs are rotated by the pupils' control points.
    Here the pupils are added.
    Raises FileFormatError if an asset is missing or damaged.
    """
    face = load_face()
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(face.mesh.vertices))
    nearest = np.asarray(KDTree(face.mesh.vertices).query(face.control_points)[1])
    displacements = (shapes.offsets[:, nearest] / face.fapu.lengths()).astype(np.float32)
    by_name = dict(zip(shapes.names, displacements, strict=True))
    for direction, (x, y, degrees) in FULL_GAZE.items():
        distance = EYE_RADIUS * np.sin(np.radians(degrees))
        for side, mirror in (("Left", 1), ("Right", -1)):
            pupil = CONTROL_POINT_INDEX[f"pupil_{side[0].lower()}"]
            by_name[f"eyeLook{direction}{side}"][pupil] = [x * mirror * distance, y * distance, 0.0]
    return by_name
