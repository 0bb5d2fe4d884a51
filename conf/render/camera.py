"""Camera of the rendered image: the viewer's orbit, zoom and pan, and the projection.

Image coordinates are those of `HeadPose`: image heights from the centre, x right, y up. The camera has a long focal
length and points at the head: a point in the plane of the face is projected exactly as by the scaled orthographic
pose; the nose is drawn a little larger, the ears a little smaller.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose

CAMERA_DISTANCE_CM = 110.0  # from camera to face, as for a portrait lens: much nearer, the nose is enlarged
FACE_PLANE_CM = 4.0  # the eyes and lips of the canonical face lie about this far in front of its origin
DEPTH_CM = 60.0  # half of the depth range

ORBIT_PER_HEIGHT = np.pi  # rad per image height of a drag
ZOOM_PER_STEP = 1.1
ZOOM_LIMITS = (0.2, 8.0)
PITCH_LIMIT = np.pi / 2

TOGGLES = ("wireframe", "points", "stats", "help", "centred", "portrait")  # switches of ViewState


@dataclass(frozen=True)
class ViewState:
    """Immutable view settings of the viewer, applied on top of the sender's head pose.

    yaw, pitch : rotation of the head by the viewer, rad, towards the image's right and up
    zoom : magnification about the image's centre
    pan : shift in image heights, x right, y up
    stats : whether the call statistics are a panel instead of one line
    """

    yaw: float = 0.0
    pitch: float = 0.0
    zoom: float = 1.0
    pan: tuple[float, float] = (0.0, 0.0)
    wireframe: bool = False
    points: bool = False
    stats: bool = False
    help: bool = False
    centred: bool = True
    portrait: bool = True

    def orbited(self, dx: float, dy: float) -> "ViewState":
        """Return the view rotated by a drag: dx, dy in image heights, x right, y up."""
        pitch = float(np.clip(self.pitch + dy * ORBIT_PER_HEIGHT, -PITCH_LIMIT, PITCH_LIMIT))
        return replace(self, yaw=self.yaw + dx * ORBIT_PER_HEIGHT, pitch=pitch)

    def zoomed(self, steps: float) -> "ViewState":
        """Return the view magnified by steps of the mouse wheel."""
        return replace(self, zoom=float(np.clip(self.zoom * ZOOM_PER_STEP**steps, *ZOOM_LIMITS)))

    def panned(self, dx: float, dy: float) -> "ViewState":
        """Return the view shifted by a drag: dx, dy in image heights, x right, y up."""
        return replace(self, pan=(self.pan[0] + dx, self.pan[1] + dy))

    def toggled(self, name: str) -> "ViewState":
        """Return the view with one of TOGGLES switched. Raises ValueError for another name."""
        if name not in TOGGLES:
            raise ValueError(f"name must be one of {', '.join(TOGGLES)}, got {name!r}")
        switched: dict[str, Any] = {name: not getattr(self, name)}
        return replace(self, **switched)

    def reset(self) -> "ViewState":
        """Return the view without rotation, zoom and shift; the switches stay as they are."""
        return replace(self, yaw=0.0, pitch=0.0, zoom=1.0, pan=(0.0, 0.0))


def view_rotation(pose: HeadPose, view: ViewState) -> NDArray[np.float64]:
    """Return the (3, 3) rotation from face axes to image axes, the viewer's orbit included."""
    cy, sy, cp, sp = np.cos(view.yaw), np.sin(view.yaw), np.cos(view.pitch), np.sin(view.pitch)
    yaw = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    pitch = np.array([[1.0, 0.0, 0.0], [0.0, cp, sp], [0.0, -sp, cp]])
    orbit: NDArray[np.float64] = pitch @ yaw @ pose.matrix()
    return orbit


def clip_matrix(pose: HeadPose, view: ViewState, *, aspect: float) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from face coordinates (cm, homogeneous column) to OpenGL's clip coordinates.

    aspect : width of the image over its height
    """
    rotation = view_rotation(pose, view)
    scale = np.exp(pose.log_scale)
    w = np.append(-rotation[2] / CAMERA_DISTANCE_CM, 1.0 + FACE_PLANE_CM * rotation[2, 2] / CAMERA_DISTANCE_CM)
    centre = view.zoom * pose.position + view.pan
    matrix = np.zeros((4, 4))
    matrix[:2, :3] = view.zoom * scale * rotation[:2]
    matrix[:2] += centre[:, None] * w
    matrix[0] *= 2 / aspect
    matrix[1] *= 2
    matrix[2, :3] = -rotation[2] / DEPTH_CM
    matrix[3] = w
    return matrix


def project(points: NDArray[np.floating], clip: NDArray[np.float64], size: tuple[float, float]) -> NDArray[np.float64]:
    """Return the projected points: (n, 2) pixels from the upper left corner, x right, y down.

    points : (n, 3) face coordinates, cm
    clip : (4, 4) from `clip_matrix`
    size : width and height in pixels
    """
    homogeneous = points @ clip[:, :3].T + clip[:, 3]
    ndc = homogeneous[:, :2] / homogeneous[:, 3:]
    return np.stack([(ndc[:, 0] + 1) / 2 * size[0], (1 - ndc[:, 1]) / 2 * size[1]], axis=1)
