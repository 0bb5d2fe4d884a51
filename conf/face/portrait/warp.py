"""Deform a photo with the fifty control points: expressions by radial basis functions, head rotation by depth.

Every vertex of the photo's mesh gets a depth, so it is a point of the head in space. A motion frame gives the control
points in face axes. Their displacement since the photo is interpolated to all vertices with one matrix, and the head
pose projects them into the image. Neck and shoulders follow the head with falling weight, and move with it where it
moves farther than a neck bends. Large rotations and extreme expressions, which one photo cannot show, are limited
softly.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.control_points import CONTROL_POINT_COUNT, EYE_CORNERS, PUPILS, control_point_indices
from conf.face.deformation.rbf import KERNELS, build_operator
from conf.face.deformation.regions import Regions, blend_fields
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.face.head_pose import HeadPose
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours
from conf.face.portrait.contours import OVAL_ROWS, PORTRAIT_LANDMARKS
from conf.face.portrait.lip_lid_gaps import enforce_min_gap
from conf.face.portrait.motion_deadband import dampen_points, dampen_vertices, stillness_weight
from conf.face.portrait.photo_mesh import PhotoMesh, build_mesh
from conf.face.portrait.photographed_face import PhotographedFace, project
from conf.face.portrait.untangle import untangle
from conf.face.portrait.vertex_weights import head_weights
from conf.face.rotations import rotation_matrix, rotation_vector

THIN_PLATE = KERNELS["thin-plate"]
MAX_ROTATION = np.radians(32)  # out of the image plane, relative to the photo
SOFT_KNEE = 0.7  # of a limit: values below it are unchanged
DEPTH_SLOPE = 0.5  # decrease of depth with distance beyond the face's oval
DEPTH_ROUNDS = 3  # of smoothing: the steep sides of nose and face would fold at small rotations
MAX_DEPTH_CM = 5.0  # behind the oval
MIN_FACE_CM = 4.0  # width and height of a face's oval
NECK_REACH_CM = np.array([3.5, 2.0])  # sideways and up or down: farther than that the torso moves with the head
NECK_GROWTH = 0.12  # of the logarithm of the head's size: nearer or farther the torso moves with it
ANCHOR_RINGS = (1.45, 1.8)  # of the oval: points that no expression moves
REGION_SHARPNESS = 0.9  # slope of the transition between the regions, as on the head
REGION_REACH_CM = {"mouth": 6.0, "eye": 3.0}  # beyond it both regions have equal weights
_NEAREST = 8  # outline points that a vertex's depth is interpolated from

_UPPER, _LOWER = control_point_indices("eyelid_upper"), control_point_indices("eyelid_lower")
_MOUTH = (contours.UPPER_OUTER_LIP + contours.UPPER_INNER_LIP, contours.LOWER_OUTER_LIP + contours.LOWER_INNER_LIP)
_EYES = (contours.UPPER_LID_R + contours.UPPER_LID_L, contours.LOWER_LID_R + contours.LOWER_LID_L)
# (n, 1) cm: limit of a control point's displacement since the photo
_LIMITS = np.full((CONTROL_POINT_COUNT, 1), 1.6)
_LIMITS[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin")] = 5.0
_LIMITS[
    control_point_indices("inner_lip_corner", "inner_lip_upper", "outer_lip_upper", "outer_lip_corner", "cupids")
] = 2.5


class PortraitWarp:
    """Deforms the mesh of one photo."""

    def __init__(self, shape: PhotographedFace, /) -> None:
        """Build mesh and matrix. Raises ValueError or scipy's QhullError if the points are not those of a face."""
        if np.ptp(shape.points[OVAL_ROWS, :2], axis=0).min() < MIN_FACE_CM:
            raise ValueError("points must be those of a face")
        self.shape = shape
        self.mesh: PhotoMesh = build_mesh(shape)
        self.scale = float(np.exp(shape.pose.log_scale))  # image heights of 1 cm of the face in the photo
        rotation = shape.pose.matrix()
        self.positions_cm = flat = (self.mesh.positions - shape.pose.position) / self.scale  # (V, 2)
        depth = _depths(flat, shape.points @ rotation.T)
        for _ in range(DEPTH_ROUNDS):
            depth[CONTROL_POINT_COUNT:] = (self.mesh.neighbour_mean @ depth)[CONTROL_POINT_COUNT:]
        self._solid = np.column_stack([flat, depth]) @ rotation  # (V, 3) cm, face axes
        self._head_weights = head_weights(flat, self.mesh.positions, shape)  # (V, 2)
        self.fields = split_photo_regions(flat)
        self.on_face = _within_oval(flat)  # (V,) bool
        self._matrix = _expression_matrix(flat, self.fields)
        self._neutral, self._fapu_lengths = shape.neutral, shape.fapu_lengths

    def set_neutral(self, neutral: NDArray[np.float64], fapu_lengths: NDArray[np.float64], /) -> None:
        """Replace the neutral pose, (n, 3) cm, and the FAPU lengths by better estimates. The photo stays as it is."""
        self._neutral, self._fapu_lengths = neutral, fapu_lengths

    def control_points(self, displacements: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return the control points (n, 3), cm in face axes, of displacements (n, 3) in FAPU units."""
        points = self._neutral + displacements * self._fapu_lengths
        gap = self._neutral[_UPPER, 1] - self._neutral[_LOWER, 1]
        openness = np.clip(1 + (displacements[_UPPER, 1] - displacements[_LOWER, 1]) / UNITS_PER_DISTANCE, 0, 2)
        # The tracker's lids do not quite meet, and differ: remove the remaining gap as the eye closes.
        remaining = gap - self._fapu_lengths[_UPPER, 1] * UNITS_PER_DISTANCE
        points[_UPPER, 1] -= remaining * np.maximum(0.0, 1 - openness) ** 2
        for pupil, corners in zip(PUPILS, EYE_CORNERS, strict=True):
            points[pupil] += (points - self._neutral)[corners].mean(axis=0)
            points[pupil, 2] = self.shape.points[pupil, 2]
        return np.asarray(points)

    def photo_displacements(self) -> NDArray[np.float64]:
        """Return the displacements (n, 3), FAPU units, of the photo itself."""
        return self.displacements(self.shape.points[:CONTROL_POINT_COUNT])

    def displacements(self, points: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the displacements (n, 3), FAPU units, of control points (n, 3), cm in face axes."""
        motion = points - self._neutral
        for pupil, corners in zip(PUPILS, EYE_CORNERS, strict=True):
            motion[pupil] -= motion[corners].mean(axis=0)
            motion[pupil, 2] = 0.0
        return np.asarray(motion / self._fapu_lengths)

    def deform(self, displacements: NDArray[np.floating], pose: HeadPose, /) -> NDArray[np.float64]:
        """Return the deformed positions (V, 2), without folds. displacements : (n, 3) FAPU units"""
        motion = dampen_points(self.control_points(displacements) - self.shape.points[:CONTROL_POINT_COUNT])
        target = self._project(_soft_limit(motion, _LIMITS), limit_rotation(pose, self.shape.pose))
        return untangle(dampen_vertices(target, self.mesh.positions, self.on_face, self.scale), self.mesh)

    def deform_to(self, points: NDArray[np.float64], pose: HeadPose, /) -> NDArray[np.float64]:
        """Return the positions (V, 2) for control points (n, 3), cm in face axes, without dead band."""
        motion = _soft_limit(points - self.shape.points[:CONTROL_POINT_COUNT], _LIMITS)
        return untangle(self._project(motion, limit_rotation(pose, self.shape.pose)), self.mesh)

    def _project(self, motion: NDArray[np.float64], pose: HeadPose) -> NDArray[np.float64]:
        """Return the positions (V, 2), maybe with folds. motion : (n, 3) cm since the photo"""
        projected = project(self._solid + self._matrix @ motion.astype(np.float32), pose)
        torso = self._torso(pose)
        target = torso + self._head_weights * (projected - torso)
        count = len(PORTRAIT_LANDMARKS)
        target[:count] = enforce_min_gap(target[:count], float(np.exp(pose.log_scale)))
        for eye in self.mesh.eyes:
            eye.apply(target)
        return np.asarray(target)

    def _torso(self, pose: HeadPose) -> NDArray[np.float64]:
        """Return (V, 2), the photo's vertices moved and scaled as far as the neck alone cannot move the head."""
        centre = self.shape.points[OVAL_ROWS].mean(axis=0)[None]
        before, now = project(centre, self.shape.pose)[0], project(centre, pose)[0]
        limits = self.scale * NECK_REACH_CM
        shift = now - before - limits * _soft_limit(((now - before) / limits)[None], 1.0)[0]
        growth = pose.log_scale - self.shape.pose.log_scale
        growth -= float(_soft_limit(np.array([[growth]]), NECK_GROWTH)[0, 0])
        return np.asarray(before + shift + np.exp(growth) * (self.mesh.positions - before))

    def stillness(self, positions: NDArray[np.float64], /) -> float:
        """Return 1 if the face in positions (V, 2) is where it was photographed, falling to 0 far away."""
        return stillness_weight(positions, self.mesh.positions, self.on_face, self.scale)


def thin_plate_matrix(
    positions: NDArray[np.float64],
    centres: NDArray[np.float64],
    /,
    *,
    epsilon: float = THIN_PLATE.epsilon,
    regions: Regions | None = None,
    smoothing: float = 0.0,
) -> NDArray[np.float32]:
    """Return the (V, n) matrix that interpolates values at centres (n, 2) to positions (V, 2) in the plane.

    epsilon, regions, smoothing : as in build_operator
    """
    operator = build_operator(
        _in_space(positions),
        _in_space(centres),
        kernel=THIN_PLATE,
        epsilon=epsilon,
        regions=regions,
        smoothing=smoothing,
    )
    return operator.matrix


def limit_rotation(pose: HeadPose, photo_pose: HeadPose, /) -> HeadPose:
    """Return the pose with its rotation out of the image plane limited to what the photo can show.

    The rotation since the photo is decomposed into one in the image plane, which is not limited, and the shortest one
    that then yields the viewing direction.
    """
    first = photo_pose.matrix()
    rotation = pose.matrix() @ first.T
    direction = rotation[:, 2]
    axis = np.array([-direction[1], direction[0], 0.0])
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    angle = float(np.arctan2(length, direction[2]))
    in_plane = rotation_matrix(-angle * axis) @ rotation
    limited = float(_soft_limit(np.array([[angle]]), MAX_ROTATION)[0, 0])
    rotation = rotation_matrix(limited * axis) @ in_plane @ first
    return HeadPose(rotation_vector(rotation), pose.position, pose.log_scale)


def _soft_limit(vectors: NDArray[np.float64], limits: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return vectors (k, m) shortened below their limits (k, 1): unchanged up to the knee, asymptotic beyond."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    knee = SOFT_KNEE * np.asarray(limits)
    span = np.asarray(limits) - knee
    excess = np.maximum(0.0, lengths - knee)
    limited = np.minimum(lengths, knee) + span * excess / (span + excess)
    return np.asarray(vectors * (limited / np.maximum(lengths, 1e-9)))


def _depths(positions_cm: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (V,) cm towards the viewer: interpolated between the face's points (D, 3), decreasing beyond its oval."""
    distance, nearest = cKDTree(points[:, :2]).query(positions_cm, k=_NEAREST)
    weights = 1 / np.maximum(distance, 1e-6) ** 2
    depth = np.sum(weights * points[nearest, 2], axis=1) / weights.sum(axis=1)
    radius, oval_radius = _radii(positions_cm, points[OVAL_ROWS, :2])
    return np.asarray(depth - np.minimum(DEPTH_SLOPE * np.maximum(0.0, radius - oval_radius), MAX_DEPTH_CM))


def _within_oval(positions_cm: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (V,) whether vertices are well within the face's oval."""
    radius, oval_radius = _radii(positions_cm, positions_cm[OVAL_ROWS])
    return np.asarray(radius < 0.92 * oval_radius)


def _radii(
    positions_cm: NDArray[np.float64], oval: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances (V,) of vertices and of their nearest oval points from the oval's centre."""
    centre = oval.mean(axis=0)
    nearest = oval[cKDTree(oval).query(positions_cm)[1]]
    return np.linalg.norm(positions_cm - centre, axis=1), np.linalg.norm(nearest - centre, axis=1)


def split_photo_regions(positions_cm: NDArray[np.float64], /) -> Regions:
    """Return four fields of V vertices without anchors: control points of one lip or lid do not move the other one."""
    mouth = _lower_weight(positions_cm, _MOUTH, REGION_REACH_CM["mouth"])
    eyes = _lower_weight(positions_cm, _EYES, REGION_REACH_CM["eye"])
    return Regions(blend_fields(mouth, eyes), np.empty((0, 3)))


def _lower_weight(
    positions_cm: NDArray[np.float64], sides: tuple[tuple[int, ...], tuple[int, ...]], reach: float
) -> NDArray[np.float64]:
    """Return (V,): 0 at the upper lip or lids, 1 at the lower ones, 0.5 at the corners and far away."""
    common = set(sides[0]) & set(sides[1])
    rows = [contours.landmark_rows(tuple(i for i in side if i not in common)) for side in sides]
    upper, lower = (cKDTree(positions_cm[side]).query(positions_cm)[0] for side in rows)
    balance = (upper - lower) / np.maximum(upper + lower, 1e-9)
    near = np.clip(2 * (1 - np.minimum(upper, lower) / reach), 0, 1)
    weight = smoothstep(0.5 + REGION_SHARPNESS * near * balance)
    weight[rows[0]], weight[rows[1]], weight[contours.landmark_rows(tuple(common))] = 0.0, 1.0, 0.5
    return np.asarray(weight)


def _expression_matrix(positions_cm: NDArray[np.float64], fields: Regions) -> NDArray[np.float32]:
    """Return the (V, n) matrix from displacements of the control points to offsets of the vertices."""
    oval = positions_cm[OVAL_ROWS]
    centre = oval.mean(axis=0)
    anchors = np.concatenate([centre + ring * (oval[::2] - centre) for ring in ANCHOR_RINGS])
    regions = Regions(fields.fields, _in_space(anchors))
    matrix = thin_plate_matrix(positions_cm, positions_cm[:CONTROL_POINT_COUNT], regions=regions)
    radius = np.linalg.norm(positions_cm - centre, axis=1) / np.linalg.norm(oval - centre, axis=1).max()
    matrix = np.asarray(matrix * np.clip((ANCHOR_RINGS[-1] - radius) / 0.3, 0, 1)[:, None])
    matrix[:CONTROL_POINT_COUNT] = np.eye(CONTROL_POINT_COUNT)
    return np.asarray(matrix, dtype=np.float32)


def _in_space(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack([positions, np.zeros(len(positions))])
