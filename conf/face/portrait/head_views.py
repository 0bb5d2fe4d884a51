"""Views of the head: other images of it for the photo's mesh, each of one head pose and expression.

The face is drawn the worse the farther it is from what an image shows. A descriptor says how a face looks: where its
control points are in the image, apart from position and size. Both sides of a call compute it alike: the sender adds a
view if the face was often far from photo and views, the receiver blends the images with the nearest descriptors.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.head_pose import HeadPose
from conf.face.interpolation import smoothstep
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.image_blending import weights_of_distances
from conf.face.portrait.warp import PortraitWarp

VIEW_POWER = 4.0  # of inverse distance weighting: two views blended equally blur
VIEW_STEP_CM = 0.06  # RMS distance of the control points that counts as 1 when photo and views are blended
EDGE = (0.9, 1.12)  # of the radius of the face's oval: a view is opaque within, transparent beyond


@dataclass(frozen=True)
class HeadView:
    """Where the mesh of a photo is in a view.

    positions : (V, 2) image heights from the frame's centre; descriptor : (2n,) cm
    """

    positions: NDArray[np.float64]
    descriptor: NDArray[np.float64]

    @classmethod
    def of_points(cls, warp: PortraitWarp, points: NDArray[np.float64], pose: HeadPose, /) -> "HeadView":
        """Return the view of a face with control points (n, 3), cm in face axes."""
        return cls(warp.deform_to(points, pose), describe_shape(points, pose))


def describe_shape(points: NDArray[np.floating], pose: HeadPose, /) -> NDArray[np.float64]:
    """Return the descriptor (2n,) of control points (n, 3): cm in the image plane, from their centre.

    Its norm over sqrt(n) is the RMS distance of the points.
    """
    flat = points @ pose.matrix()[:2].T
    return np.asarray((flat - flat.mean(axis=0)).ravel(), np.float64)


def view_weights(current: NDArray[np.float64], shapes: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the weights (..., M) of photo and views with descriptors (M, 2n) in a face with the current one (..., 2n).

    Only the nearest ones have a weight above 0.
    """
    distances = np.linalg.norm(current[..., None, :] - shapes, axis=-1) / np.sqrt(CONTROL_POINT_COUNT)
    return weights_of_distances(distances / VIEW_STEP_CM, power=VIEW_POWER)


def view_alpha(warp: PortraitWarp, /) -> NDArray[np.float64]:
    """Return (V,) the opacity of views at each vertex: the face, faded towards hair and neck."""
    oval = warp.positions_cm[OVAL_ROWS]
    centre = oval.mean(axis=0)
    angles = np.arctan2(*(oval - centre).T[::-1])
    order = np.argsort(angles)
    radii = np.linalg.norm(oval - centre, axis=1)[order]
    offset = warp.positions_cm - centre
    limit = np.interp(np.arctan2(offset[:, 1], offset[:, 0]), angles[order], radii, period=2 * np.pi)
    radius = np.linalg.norm(offset, axis=1) / np.maximum(limit, 1e-6)
    return smoothstep((EDGE[1] - radius) / (EDGE[1] - EDGE[0]))
