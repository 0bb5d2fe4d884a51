"""Draw a mesh from several sides and let the tracker say where its landmarks are.

Each landmark is seen in several drawings, along a line of sight in each; the point nearest to all the lines is
where the tracker sees it in space. Each drawing is tracked as it is and mirrored, so that neither the lamp, which
stands on one side, nor the tracker's own habits make a face crooked.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.face_model import FaceModel
from conf.face.fapu import Fapu
from conf.face.fitting.face_prior import OBSERVED_LANDMARKS, OBSERVED_MIRROR_INDICES
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.render.camera import ViewState, clip_matrix
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.tracker import FaceTracker

IMAGE_SIZE = 640  # pixels: the tracker looks at 256 x 256 of the face, so more adds nothing
FRONT = (0.0, 0.0)


@dataclass(frozen=True)
class LandmarkView:
    """What the tracker saw in one drawing.

    places : (m, 2) landmarks in the picture, those of conf.face.fitting.face_prior, -1 to 1, x right, y up
    clip : (4, 4) from the mesh's coordinates to clip coordinates
    """

    places: NDArray[np.float64]
    clip: NDArray[np.float64]


class MultiviewTracker:
    """A mesh before the camera."""

    def __init__(
        self, window: OffscreenWindow, tracker: FaceTracker, mesh: Mesh, placeholder_points: NDArray[np.float64]
    ) -> None:
        """stand_in : (n, 3) control points that the renderer needs to know and that need not be right"""
        self._window, self._tracker = window, tracker
        self._vertices = mesh.vertices.astype(np.float32)
        operator = np.zeros((len(mesh.vertices), CONTROL_POINT_COUNT), np.float32)
        self._renderer = FaceRenderer(
            window.ctx, FaceModel(mesh, placeholder_points, Fapu.measure(placeholder_points), operator)
        )

    def draw(self, pose: HeadPose) -> NDArray[np.uint8]:
        """Return a drawing (H, W, 3) uint8 BGR of the mesh."""
        self._window.begin()
        self._renderer.draw(self._vertices, pose, ViewState(), self._window.framebuffer)
        self._window.end()
        return self._window.read()

    def track_views(self, pose: HeadPose) -> Iterator[LandmarkView]:
        """Yield what the tracker sees in a drawing and in its mirror image; nothing where it finds no face."""
        drawing = self.draw(pose)
        clip = clip_matrix(pose, ViewState(), aspect=1.0)
        for mirrored in (False, True):
            pixels = np.ascontiguousarray(drawing[:, ::-1]) if mirrored else drawing
            tracking = self._tracker.track(pixels)
            if tracking is not None:
                tracking = self._tracker.track(pixels)  # the first look finds the face, this one has it well framed
            if tracking is None:
                continue
            places = tracking.landmarks[OBSERVED_LANDMARKS, :2].astype(np.float64) / IMAGE_SIZE * [2, -2] + [-1, 1]
            yield LandmarkView(places[OBSERVED_MIRROR_INDICES] * [-1, 1] if mirrored else places, clip)

    def __enter__(self) -> "MultiviewTracker":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.release()

    def release(self) -> None:
        """Free what is on the card."""
        self._renderer.release()


def camera_pose(side: tuple[float, float], /, *, height: float, centre: tuple[float, float] = (0.0, 0.0)) -> HeadPose:
    """Return the pose that shows a face turned by yaw and pitch, in degrees.

    height : of the picture, cm
    centre : what lies in its middle, x right, y up, cm
    """
    yaw, pitch = side
    rotation = Rotation.from_euler("XY", [-pitch, yaw], degrees=True)
    return HeadPose(rotation.as_rotvec(), -np.array(centre) / height, float(-np.log(height)))


def triangulate(sights: Sequence[LandmarkView]) -> NDArray[np.float64]:
    """Return the (m, 3) points nearest to all lines of sight, in the mesh's coordinates."""
    planes = np.concatenate([_planes(sight) for sight in sights], axis=1)  # (m, planes, 4)
    planes = planes / np.linalg.norm(planes[..., :3], axis=2, keepdims=True)
    normal, offset = planes[..., :3], planes[..., 3]
    system = np.einsum("npi,npj->nij", normal, normal)
    return np.asarray(np.linalg.solve(system, -np.einsum("npi,np->ni", normal, offset)[..., None])[..., 0])


def _planes(sight: LandmarkView) -> NDArray[np.float64]:
    """Return (m, 2, 4): the two planes, homogeneous, that meet in the line of sight of each point."""
    x, y, _, w = sight.clip
    return np.stack([x - sight.places[:, :1] * w, y - sight.places[:, 1:] * w], axis=1)
