"""Measure speed and accuracy of the deformer; the rival solves the RBF system for every frame.

    python tools/bench/deformation.py [--json]

Speed, on the default head cut to 5,000, 10,000 and 20,000 vertices, one BLAS thread, medians. `build` is all that is
computed once for a face and kernel: distances along the surface, regions, solve, matrix. `apply` is one frame: B times
(50, 3) plus the neutral vertices. `rival` is scipy's RBFInterpolator built for each frame, as in the thesis;
`difference` is the maximum difference of the two without regions, for displacements of about 1 cm.

Accuracy: each of the 52 sculpted blendshapes is left out in turn, the operator is trained on the other 51, and the
left-out shape is rebuilt from the displacements of its 50 control points. `rms_mm` is the RMS error over all vertices
of the skin; `rms_moving_mm` is over those that the shape moves by more than 0.1 mm; `generic` is the RBF without
training.
"""

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from conf.face.control_points import LOWER_LIP, PUPILS, UPPER_LIP, control_point_indices
from conf.face.default_head import DEFAULT_HEAD, default_joints
from conf.face.deformation.blendshapes import Blendshapes, load_blendshapes
from conf.face.deformation.eyelid_helpers import append_helpers, fold_helpers, helpers_on_parabola
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.operator_builder import choose_anchors
from conf.face.deformation.rbf import KERNELS, build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.deformation.ridge_refinement import refine_with_blendshapes, subtract_jaw_motion
from conf.face.deformation.rig import jaw_offsets
from conf.face.deformation.rig_builder import RigJoints, build_rig
from conf.face.formats.ppc import read_ppc
from conf.face.head_pose import ES0_CM
from conf.face.loading import load_face
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph

SIZES = (5_000, 10_000, 20_000)
KERNEL = KERNELS["multiquadric"]
SMOOTHING = DeformerOptions().smoothing
MOVING_CM = 0.01
MM = 10.0  # millimetres in a centimetre
CORNERS = control_point_indices("inner_lip_corner", "outer_lip_corner")
CORNER_CM = 1.0  # distance from a corner of the mouth within which both lips move together
LIP_CM = 0.5  # distance from a lip's control point within which a vertex belongs to that lip


@dataclass(frozen=True)
class Cost:
    """Median times for one size, and the maximum difference to the rival."""

    vertices: int
    build_ms: float
    apply_ms: float
    rival_ms: float
    difference_cm: float


def median_ms(work: Callable[[], object], repeats: int) -> float:
    """Return the median time of a function, ms."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def head_of(mesh: Mesh, count: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return the `count` vertices nearest to the face, subdivided if there are fewer, and their triangles."""
    vertices, triangles = mesh.vertices, mesh.triangles.astype(np.int64)
    while len(vertices) < count:
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys, middles = np.unique(edges[:, 0] * len(vertices) + edges[:, 1], return_inverse=True)
        (a, b, c), (x, y, z) = triangles.T, middles.reshape(-1, 3).T + len(vertices)
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))])
        vertices = np.concatenate([vertices, vertices[np.stack(np.divmod(keys, len(vertices)))].mean(axis=0)])
    face = np.array([0.0, 0.0, vertices[:, 2].max()])
    kept = np.argsort(np.linalg.norm(vertices - face, axis=1))[:count]
    index = np.full(len(vertices), -1)
    index[kept] = np.arange(count)
    triangles = index[triangles]
    return vertices[kept], triangles[(triangles >= 0).all(axis=1)].astype(np.int32)


def rbf_matrix(vertices: NDArray[np.float64], points: NDArray[np.float64], regions: Regions) -> NDArray[np.float32]:
    """Return the split RBF operator, as conf.face.deformation.operator_builder builds it."""
    helpers = helpers_on_parabola(points)
    centres, fields = append_helpers(points, regions, helpers)
    operator = build_operator(
        vertices, centres, kernel=KERNEL, epsilon=KERNEL.epsilon, regions=fields, smoothing=SMOOTHING
    )
    return fold_helpers(operator.matrix, helpers)


def measure_cost(mesh: Mesh, points: NDArray[np.float64], count: int) -> Cost:
    """Measure the time of building B, of applying it and of the rival at one size."""
    vertices, triangles = head_of(mesh, count)
    neutral = vertices.astype(np.float32)
    displacements = np.random.default_rng(1).normal(size=points.shape)
    displacements_f4 = displacements.astype(np.float32)

    def build() -> NDArray[np.float32]:
        anchors = choose_anchors(vertices, points, eye_distance=ES0_CM)
        regions = split_regions(SurfaceGraph(vertices, triangles), points, anchors=anchors).excluding(PUPILS)
        return rbf_matrix(vertices, points, regions)

    def rival() -> NDArray[np.float64]:
        field = RBFInterpolator(points, displacements, kernel="multiquadric", epsilon=KERNEL.epsilon)
        return np.asarray(field(vertices))

    build_ms = median_ms(build, 9)
    matrix = build()
    out = np.empty_like(neutral)

    def apply() -> None:
        np.matmul(matrix, displacements_f4, out=out)
        np.add(out, neutral, out=out)

    whole = build_operator(vertices, points, kernel=KERNEL, epsilon=KERNEL.epsilon).matrix
    difference = float(np.abs(whole @ displacements_f4 - rival()).max())
    return Cost(count, build_ms, median_ms(apply, 300), median_ms(rival, 9), difference)


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of the trained operator.

    rms, rms_moving, generic : error of each sculpted blendshape when it is left out of training, mm
    leak : maximum entry of one lip's columns of B on the vertices of the other lip
    """

    rms: dict[str, float]
    rms_moving: dict[str, float]
    generic: dict[str, float]
    leak: float


def measure_accuracy(mesh: Mesh, points: NDArray[np.float64], joints: RigJoints, shapes: Blendshapes) -> Accuracy:
    """Leave each sculpted blendshape out of training and rebuild it from its control points."""
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    anchors = choose_anchors(mesh.vertices, points, eye_distance=ES0_CM, initial=joints.anchors)
    regions = split_regions(surface, points, anchors=anchors).excluding(PUPILS)
    matrix = rbf_matrix(mesh.vertices, points, regions)
    moved = shapes.offsets[:, surface.nearest_vertices(points, tolerance=0.0)]
    skin = mesh.group_vertices("skin")
    accuracy = Accuracy({}, {}, {}, lip_leak(load_face().operator, surface, points))
    for i, name in enumerate(shapes.names):
        others = [j for j in range(len(shapes.names)) if j != i]
        subset = Blendshapes(tuple(shapes.names[j] for j in others), shapes.offsets[others])
        jaw = build_rig(mesh, points, joints, subset).jaw
        assert jaw is not None, "the default head has a jaw"
        left, offsets = subtract_jaw_motion(jaw, points, moved, shapes.offsets)
        rebuilt = refine_with_blendshapes(matrix, left[others], offsets[others], regions=regions) @ left[i]
        rebuilt[jaw.vertices] += jaw_offsets(jaw.weighted_offsets, jaw.weights, jaw.estimate_motion(points, moved[i]))
        sculpted = shapes.offsets[i, skin]
        moving = np.linalg.norm(sculpted, axis=1) > MOVING_CM
        accuracy.rms[name] = rms_mm(rebuilt[skin] - sculpted)
        accuracy.rms_moving[name] = rms_mm((rebuilt[skin] - sculpted)[moving])
        accuracy.generic[name] = rms_mm(matrix[skin] @ moved[i] - sculpted)
    return accuracy


def rms_mm(errors: NDArray[np.floating]) -> float:
    """Return the root of the mean squared length of (k, 3) errors in cm, in mm."""
    return MM * float(np.sqrt((errors.astype(np.float64) ** 2).sum(axis=1).mean())) if len(errors) else 0.0


def lip_leak(matrix: NDArray[np.float32], surface: SurfaceGraph, points: NDArray[np.float64]) -> float:
    """Return the maximum weight of one lip's points on the other lip, except near the corners of the mouth."""
    seeds = surface.nearest_vertices(points, tolerance=0.0)
    far = surface.distances(seeds[CORNERS], limit=1.0) >= CORNER_CM
    largest = 0.0
    for lip, other in ((UPPER_LIP, LOWER_LIP), (LOWER_LIP, UPPER_LIP)):
        on_lip = far & (surface.distances(seeds[lip], limit=1.0) < LIP_CM)
        largest = max(largest, float(np.abs(matrix[on_lip][:, other]).max()))
    return largest


def main() -> None:
    """Print the tables, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    options = parser.parse_args()
    mesh, points = load_mesh(DEFAULT_HEAD), read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    sculpted = DEFAULT_HEAD.with_name("shapes.npz")
    costs = [measure_cost(mesh, points, size) for size in SIZES]
    shapes = load_blendshapes(sculpted, len(mesh.vertices)) if sculpted.is_file() else None
    accuracy = None if shapes is None else measure_accuracy(mesh, points, default_joints(), shapes)
    print_json(costs, accuracy) if options.json else print_tables(costs, accuracy)


def print_json(costs: list[Cost], accuracy: Accuracy | None) -> None:
    """Print one object: the figures of the largest size, then those of all sizes."""
    largest = costs[-1]
    report: dict[str, object] = {
        "vertices": largest.vertices,
        "build_ms": largest.build_ms,
        "apply_ms": largest.apply_ms,
        "rival_ms": largest.rival_ms,
        "max_difference_cm": largest.difference_cm,
        "sizes": [asdict(cost) for cost in costs],
    }
    if accuracy is not None:
        report |= {"rms_mm": accuracy.rms, "rms_moving_mm": accuracy.rms_moving, "rms_generic_mm": accuracy.generic}
        report["lip_leak"] = accuracy.leak
    print(json.dumps(report))


def print_tables(costs: list[Cost], accuracy: Accuracy | None) -> None:
    """Print the figures as tables."""
    print(f"{'vertices':>10} {'build ms':>9} {'apply ms':>9} {'rival ms':>9} {'difference cm':>14}")
    for cost in costs:
        times = f"{cost.build_ms:9.1f} {cost.apply_ms:9.3f} {cost.rival_ms:9.2f}"
        print(f"{cost.vertices:10} {times} {cost.difference_cm:14.1e}")
    if accuracy is None:
        print("the default head has no sculpted blendshapes: no table of errors")
        return
    print(f"\n{'left-out shape, mm':22} {'trained':>8} {'moving':>8} {'generic':>8}")
    for name, error in accuracy.rms.items():
        print(f"{name:22} {error:8.2f} {accuracy.rms_moving[name]:8.2f} {accuracy.generic[name]:8.2f}")
    print(f"\none lip's columns on the other lip: at most {accuracy.leak:.4f}")


if __name__ == "__main__":
    main()
