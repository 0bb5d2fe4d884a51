"""Where things stand in the receiver's picture: the viewer's orbit, zoom and pan, and the camera.

Picture coordinates are those of `HeadPose`: picture heights from the centre, x right, y up. The camera is a long lens
aimed at the head: what lies in the face's plane is exactly where the scaled orthographic pose puts it, the nose is a
little larger, the ears a little smaller.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose

CAMERA_DISTANCE_CM = 110.0  # from the lens to the face: a portrait lens; much nearer and the nose grows
FACE_PLANE_CM = 4.0  # the eyes and lips of the canonical face lie about this far in front of its origin
DEPTH_CM = 60.0  # half of the depth that is drawn

TURN_PER_HEIGHT = np.pi  # a drag over the whole height of the picture turns the head by half a turn
ZOOM_PER_STEP = 1.1
ZOOM_LIMITS = (0.2, 8.0)
PITCH_LIMIT = np.pi / 2


@dataclass(frozen=True)
class ViewState:
    """How the viewer looks at the face, beside what the sender's picture says. Every change gives a new one.

    yaw, pitch : radians the head is turned by the viewer: to the picture's right, and up
    zoom : magnification about the picture's centre
    pan : shift in picture heights, x right, y up
    """

    yaw: float = 0.0
    pitch: float = 0.0
    zoom: float = 1.0
    pan: tuple[float, float] = (0.0, 0.0)
    wireframe: bool = False
    points: bool = False
    meter: bool = True
    help: bool = False
    centred: bool = True
    portrait: bool = True

    def turned(self, dx: float, dy: float) -> "ViewState":
        """Turn the head with the hand: dx, dy in picture heights, x right, y up."""
        pitch = float(np.clip(self.pitch + dy * TURN_PER_HEIGHT, -PITCH_LIMIT, PITCH_LIMIT))
        return replace(self, yaw=self.yaw + dx * TURN_PER_HEIGHT, pitch=pitch)

    def zoomed(self, steps: float) -> "ViewState":
        """Magnify by steps of the wheel."""
        return replace(self, zoom=float(np.clip(self.zoom * ZOOM_PER_STEP**steps, *ZOOM_LIMITS)))

    def panned(self, dx: float, dy: float) -> "ViewState":
        """Shift the picture: dx, dy in picture heights, x right, y up."""
        return replace(self, pan=(self.pan[0] + dx, self.pan[1] + dy))

    def toggled(self, name: str) -> "ViewState":
        """Switch one of wireframe, points, meter, help, centred, portrait."""
        if name not in TOGGLES:
            raise ValueError(f"name must be one of {', '.join(TOGGLES)}, got {name!r}")
        switched: dict[str, Any] = {name: not getattr(self, name)}
        return replace(self, **switched)

    def reset(self) -> "ViewState":
        """Look straight at the face again; what is switched on stays on."""
        return replace(self, yaw=0.0, pitch=0.0, zoom=1.0, pan=(0.0, 0.0))


TOGGLES = ("wireframe", "points", "meter", "help", "centred", "portrait")


def view_rotation(pose: HeadPose, view: ViewState) -> NDArray[np.float64]:
    """Return the (3, 3) rotation from face axes to picture axes as the viewer sees them."""
    cy, sy, cp, sp = np.cos(view.yaw), np.sin(view.yaw), np.cos(view.pitch), np.sin(view.pitch)
    yaw = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    pitch = np.array([[1.0, 0.0, 0.0], [0.0, cp, sp], [0.0, -sp, cp]])
    orbit: NDArray[np.float64] = pitch @ yaw @ pose.matrix()
    return orbit


def clip_matrix(pose: HeadPose, view: ViewState, *, aspect: float) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from face coordinates (cm, homogeneous column) to OpenGL's clip coordinates.

    aspect : width of the picture over its height
    """
    turn = view_rotation(pose, view)
    scale = np.exp(pose.log_scale)
    w = np.append(-turn[2] / CAMERA_DISTANCE_CM, 1.0 + FACE_PLANE_CM * turn[2, 2] / CAMERA_DISTANCE_CM)
    centre = view.zoom * pose.position + view.pan
    matrix = np.zeros((4, 4))
    matrix[:2, :3] = view.zoom * scale * turn[:2]
    matrix[:2] += centre[:, None] * w
    matrix[0] *= 2 / aspect
    matrix[1] *= 2
    matrix[2, :3] = -turn[2] / DEPTH_CM
    matrix[3] = w
    return matrix


def project(points: NDArray[np.floating], matrix: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
    """Return where points fall: (n, 2) pixels from the upper left corner, x right, y down.

    points : (n, 3) face coordinates, cm
    matrix : (4, 4) of `clip_matrix`
    size : width and height in pixels
    """
    clip = points @ matrix[:, :3].T + matrix[:, 3]
    ndc = clip[:, :2] / clip[:, 3:]
    return np.stack([(ndc[:, 0] + 1) / 2 * size[0], (1 - ndc[:, 1]) / 2 * size[1]], axis=1)
