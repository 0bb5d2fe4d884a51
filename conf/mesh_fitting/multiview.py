"""Track a mesh's landmarks in images from several views, and triangulate them.

Each landmark lies on a line of sight in each image; the point nearest to all lines is its position. Each image is
tracked as it is and mirrored, so that neither the light, which is on one side, nor a bias of the tracker makes a face
asymmetric.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.face_model import FaceModel
from conf.face.fitting.face_prior import OBSERVED_LANDMARKS, OBSERVED_MIRROR_INDICES
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.render.camera import ViewState, clip_matrix
from conf.render.face_renderer import FaceRenderer
from conf.render.gpu_object import GpuObject
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.tracker import FaceTracker

IMAGE_SIZE = 640  # px: the tracker uses 256 x 256 of the face, so more adds nothing
FRONT = (0.0, 0.0)


@dataclass(frozen=True)
class LandmarkView:
    """The landmarks tracked in one image.

    positions : (m, 2) those of conf.face.fitting.face_prior, -1 to 1, x right, y up
    clip : (4, 4) from the mesh's coordinates to clip coordinates
    """

    positions: NDArray[np.float64]
    clip: NDArray[np.float64]


class MultiviewTracker(GpuObject):
    """Renders and tracks a mesh."""

    def __init__(
        self, window: OffscreenWindow, tracker: FaceTracker, mesh: Mesh, placeholder_points: NDArray[np.float64]
    ) -> None:
        """placeholder_points : (n, 3) any control points; the renderer needs some, and nothing is deformed"""
        self._window, self._tracker = window, tracker
        self._vertices = mesh.vertices.astype(np.float32)
        operator = np.zeros((len(mesh.vertices), CONTROL_POINT_COUNT), np.float32)
        model = FaceModel(mesh, placeholder_points, operator)
        self._renderer = FaceRenderer(window.ctx, model)
        self._owned = (self._renderer,)

    def track_views(self, pose: HeadPose) -> Iterator[LandmarkView]:
        """Yield the landmarks in an image and in its mirror image; nothing where no face is found."""
        self._window.begin()
        self._renderer.draw(self._vertices, pose, ViewState(), self._window.framebuffer)
        self._window.end()
        image = self._window.read()
        clip = clip_matrix(pose, ViewState(), aspect=1.0)
        for mirrored in (False, True):
            pixels = np.ascontiguousarray(image[:, ::-1]) if mirrored else image
            tracked = self._tracker.track(pixels) and self._tracker.track(pixels)  # again: now the crop fits the face
            if tracked is not None:
                xy = tracked.landmarks[OBSERVED_LANDMARKS, :2].astype(np.float64) / IMAGE_SIZE * [2, -2] + [-1, 1]
                yield LandmarkView(xy[OBSERVED_MIRROR_INDICES] * [-1, 1] if mirrored else xy, clip)


def camera_pose(view: tuple[float, float], /, *, height: float, centre: tuple[float, float] = (0.0, 0.0)) -> HeadPose:
    """Return the pose that shows a face rotated by yaw and pitch, degrees.

    height : of the image, cm; centre : the point in its middle, x right, y up, cm
    """
    yaw, pitch = view
    rotation = Rotation.from_euler("XY", [-pitch, yaw], degrees=True)
    return HeadPose(rotation.as_rotvec(), -np.array(centre) / height, float(-np.log(height)))


def triangulate(views: Sequence[LandmarkView]) -> NDArray[np.float64]:
    """Return the points (m, 3) nearest to all lines of sight, in the mesh's coordinates."""
    pairs = []  # of each view (m, 2, 4): the two homogeneous planes that intersect in each point's line of sight
    for view in views:
        x, y, _, w = view.clip
        pairs.append(np.stack([x - view.positions[:, :1] * w, y - view.positions[:, 1:] * w], axis=1))
    planes = np.concatenate(pairs, axis=1)  # (m, planes, 4)
    planes = planes / np.linalg.norm(planes[..., :3], axis=2, keepdims=True)
    normal, offset = planes[..., :3], planes[..., 3]
    system = np.einsum("npi,npj->nij", normal, normal)
    return np.asarray(np.linalg.solve(system, -np.einsum("npi,np->ni", normal, offset)[..., None])[..., 0])
