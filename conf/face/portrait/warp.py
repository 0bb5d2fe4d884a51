"""Move a photograph with the fifty points: expression by radial basis functions, head turns by depth.

Strategy. Every vertex of the photograph's mesh gets a depth, so it is a point of the head. Motion gives the control
points in face axes; what they moved since the photograph goes through one matrix to all vertices, and the head's pose
puts them into the picture. Neck and shoulders follow the head less and less; the picture's lower border stays. What
one photograph cannot show, a head turned far or a grimace out of all range, is eased to the nearest that it can.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, PUPILS, control_point_indices
from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.rbf import build_operator
from conf.face.deformation.regions import Regions
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.border_fade import border_alpha
from conf.face.portrait.head_weights import head_weights
from conf.face.portrait.lip_lid_gaps import enforce_min_gap
from conf.face.portrait.motion_deadband import dampen_points, dampen_vertices, stillness_weight
from conf.face.portrait.photo_mesh import PhotoMesh, build_mesh
from conf.face.portrait.photo_regions import split_photo_regions
from conf.face.portrait.photographed_face import PhotographedFace
from conf.face.portrait.untangle import untangle

MAX_TURN = np.radians(32)  # out of the picture's plane, against the photograph
SOFT_KNEE = 0.7  # the share of a limit that is reached unchanged
DEPTH_SLOPE = 0.5  # how fast the head falls away beyond its oval
DEPTH_ROUNDS = 3  # of smoothing: the steep sides of nose and face would fold at small turns
DEEPEST_CM = 5.0  # behind the oval
LEAST_FACE_CM = 4.0  # any side of a face's oval
ANCHOR_RINGS = (1.45, 1.8)  # of the oval: where no expression reaches
_NEAREST = 8  # outline points that a vertex's depth is taken from

_UPPER = np.array([CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]])
_LOWER = np.array([CONTROL_POINT_INDEX["eyelid_lower_l"], CONTROL_POINT_INDEX["eyelid_lower_r"]])
_CORNERS = [[CONTROL_POINT_INDEX[f"eye_inner_corner_{s}"], CONTROL_POINT_INDEX[f"eye_outer_corner_{s}"]] for s in "lr"]
_OVAL = contours.landmark_rows(contours.OVAL)


def _limits() -> NDArray[np.float64]:
    """Return (n, 1) cm: how far a control point can be from where it is in the photograph."""
    limits = np.full((CONTROL_POINT_COUNT, 1), 1.6)
    for prefixes, reach in ((("inner_lip_lower", "outer_lip_lower", "chin"), 5.0), (("inner_lip_corner",), 2.5),
                            (("inner_lip_upper", "outer_lip_upper", "outer_lip_corner", "cupids"), 2.5)):  # fmt: skip
        limits[control_point_indices(*prefixes)] = reach
    return limits


_LIMITS = _limits()


class PortraitWarp:
    """Moves the mesh of one photograph."""

    def __init__(self, shape: PhotographedFace, /) -> None:
        """Build mesh and operator. Raises ValueError or scipy's QhullError if the points are no face."""
        if np.ptp(shape.points[_OVAL, :2], axis=0).min() < LEAST_FACE_CM:
            raise ValueError("points must be those of a face")
        self.shape = shape
        self.mesh: PhotoMesh = build_mesh(shape)
        self._scale = float(np.exp(shape.pose.log_scale))
        self._turn = shape.pose.matrix()
        self.positions_cm = flat = (self.mesh.positions - shape.pose.position) / self._scale  # (V, 2) cm, picture axes
        depth = _depths(flat, shape.points @ self._turn.T)
        for _ in range(DEPTH_ROUNDS):
            depth[CONTROL_POINT_COUNT:] = (self.mesh.neighbour_mean @ depth)[CONTROL_POINT_COUNT:]
        self._solid = np.column_stack([flat, depth]) @ self._turn  # (V, 3) cm, face axes
        self._share = head_weights(flat, self.mesh.positions, shape)[:, None]
        self.border_alpha = border_alpha(flat, self.mesh.positions, shape)  # (V,) of the person, 0 to 1
        self.fields = split_photo_regions(flat)
        self.on_face = _within(flat, flat[_OVAL])  # (V,) bool
        self._operator = _operator(flat, self.fields)
        self._neutral, self._unit = shape.neutral, shape.fapu_lengths

    def set_neutral(self, neutral: NDArray[np.float64], unit: NDArray[np.float64], /) -> None:
        """Take a better estimate of the neutral pose, (n, 3) cm, and of the FAPU: the photograph stays what it is."""
        self._neutral, self._unit = neutral, unit

    def control_points(self, displacements: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return the control points (n, 3), cm in face axes, of displacements (n, 3) in FAPU units."""
        points = self._neutral + displacements * self._unit
        gap = self._neutral[_UPPER, 1] - self._neutral[_LOWER, 1]
        openness = np.clip(1 + (displacements[_UPPER, 1] - displacements[_LOWER, 1]) / UNITS_PER_DISTANCE, 0, 2)
        # The tracker's lids never quite meet, and not alike: what keeps them from it goes as the eye shuts.
        left_over = gap - self._unit[_UPPER, 1] * UNITS_PER_DISTANCE
        points[_UPPER, 1] -= left_over * np.maximum(0.0, 1 - openness) ** 2
        for pupil, corners in zip(PUPILS, _CORNERS, strict=True):
            points[pupil] += (points - self._neutral)[corners].mean(axis=0)
            points[pupil, 2] = self.shape.points[pupil, 2]
        return np.asarray(points)

    def photo_displacements(self) -> NDArray[np.float64]:
        """Return the displacements (n, 3), FAPU units, of the photograph itself."""
        moved = self.shape.points[:CONTROL_POINT_COUNT] - self._neutral
        for pupil, corners in zip(PUPILS, _CORNERS, strict=True):
            moved[pupil] -= moved[corners].mean(axis=0)
            moved[pupil, 2] = 0.0
        return np.asarray(moved / self._unit)

    def deform(self, displacements: NDArray[np.floating], pose: HeadPose, /) -> NDArray[np.float64]:
        """Return where the vertices go: (V, 2) picture heights, x right, y up. No triangle is turned over.

        displacements : (n, 3) FAPU units
        """
        moved = dampen_points(self.control_points(displacements) - self.shape.points[:CONTROL_POINT_COUNT])
        moved = _soft_limit(moved, _LIMITS)
        eased = limit_rotation(pose, self.shape.pose)
        target = self._show(self._solid + self._operator @ moved.astype(np.float32), eased)
        outlines = len(contours.PORTRAIT_LANDMARKS)
        target[:outlines] = enforce_min_gap(target[:outlines], float(np.exp(eased.log_scale)))
        for eyeball in self.mesh.eyeballs:
            eyeball.apply(target)
        return untangle(dampen_vertices(target, self.mesh.positions, self.on_face, self._scale), self.mesh)

    def stillness(self, places: NDArray[np.float64], /) -> float:
        """Return how near the face in places (V, 2) is to where it was photographed: 1 there, 0 far away."""
        return stillness_weight(places, self.mesh.positions, self.on_face, self._scale)

    def _show(self, solid: NDArray[np.float64], pose: HeadPose) -> NDArray[np.float64]:
        flat = solid @ pose.matrix()[:2].T * np.exp(pose.log_scale) + pose.position
        return np.asarray(self.mesh.positions + self._share * (flat - self.mesh.positions))


def limit_rotation(pose: HeadPose, photo_displacements: HeadPose, /) -> HeadPose:
    """Return the pose with its turn out of the picture's plane kept within what the photograph can show.

    The turn since the photograph is taken apart into one within the picture's plane, which may be any, and the shortest
    one that then brings the line of sight to where it is.
    """
    first = Rotation.from_rotvec(photo_displacements.rotation)
    turn = Rotation.from_rotvec(pose.rotation) * first.inv()
    sight = turn.apply([0.0, 0.0, 1.0])
    axis = np.array([-sight[1], sight[0], 0.0])
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    angle = float(np.arctan2(length, sight[2]))
    within = Rotation.from_rotvec(-angle * axis) * turn
    eased = float(_soft_limit(np.array([[angle]]), MAX_TURN)[0, 0])
    rotation = Rotation.from_rotvec(eased * axis) * within * first
    return HeadPose(rotation.as_rotvec(), pose.position, pose.log_scale)


def _soft_limit(vectors: NDArray[np.float64], limits: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return vectors (k, m) shortened to below their limits (k, 1): unchanged up to the knee, then ever less."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    knee = SOFT_KNEE * np.asarray(limits)
    room = np.asarray(limits) - knee
    beyond = np.maximum(0.0, lengths - knee)
    eased = np.minimum(lengths, knee) + room * beyond / (room + beyond)
    return np.asarray(vectors * (eased / np.maximum(lengths, 1e-9)))


def _depths(positions_cm: NDArray[np.float64], known: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (V,) cm towards the viewer: between the outlines' own depths, and falling away beyond them."""
    tree = cKDTree(known[:, :2])
    distance, nearest = tree.query(positions_cm, k=_NEAREST)
    weights = 1 / np.maximum(distance, 1e-6) ** 2
    depth = np.sum(weights * known[nearest, 2], axis=1) / weights.sum(axis=1)
    oval = known[_OVAL]
    middle = oval[:, :2].mean(axis=0)
    radius = np.linalg.norm(positions_cm - middle, axis=1)
    rim = np.linalg.norm(oval[cKDTree(oval[:, :2]).query(positions_cm)[1], :2] - middle, axis=1)
    fall = np.minimum(DEPTH_SLOPE * np.maximum(0.0, radius - rim), DEEPEST_CM)
    return np.asarray(depth - fall)


def _within(positions_cm: NDArray[np.float64], oval: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the vertices (V, 2) well within the face's oval (36, 2)."""
    middle = oval.mean(axis=0)
    rim = np.linalg.norm(oval[cKDTree(oval).query(positions_cm)[1]] - middle, axis=1)
    return np.asarray(np.linalg.norm(positions_cm - middle, axis=1) < 0.92 * rim)


def _operator(positions_cm: NDArray[np.float64], fields: Regions) -> NDArray[np.float32]:
    """Return the (V, n) matrix from displacements of the control points to offsets of the vertices."""
    oval = positions_cm[_OVAL]
    middle = oval.mean(axis=0)
    anchors = np.concatenate([middle + ring * (oval[::2] - middle) for ring in ANCHOR_RINGS])
    regions = Regions(fields.fields, _in_space(anchors))
    vertices = _in_space(positions_cm)
    kernel = KERNELS["thin-plate"]
    operator = build_operator(
        vertices, vertices[:CONTROL_POINT_COUNT], kernel=kernel, epsilon=kernel.epsilon, regions=regions
    )
    beyond = np.linalg.norm(positions_cm - middle, axis=1) / np.linalg.norm(oval - middle, axis=1).max()
    matrix = operator.matrix * np.clip((ANCHOR_RINGS[-1] - beyond) / 0.3, 0, 1)[:, None]
    matrix[:CONTROL_POINT_COUNT] = np.eye(CONTROL_POINT_COUNT)
    return np.asarray(matrix, dtype=np.float32)


def _in_space(positions_cm: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack([positions_cm, np.zeros(len(positions_cm))])
