"""Build the operator B of a mesh and open its mouth: python examples/deform_mesh.py [OUT.obj]"""

import sys
from pathlib import Path

import numpy as np

from conf.face import (
    CONTROL_POINTS,
    DEFAULT_HEAD,
    KERNELS,
    SurfaceGraph,
    build_operator,
    choose_anchors,
    load_mesh,
    read_ppc,
    split_regions,
)  # fmt: skip

mesh = load_mesh(DEFAULT_HEAD)
points = read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))  # (50, 3) control points, cm

# B maps displacements of the 50 control points to offsets of all V vertices. It is built once per face.
anchors = choose_anchors(mesh.vertices, points, eye_distance=6.4)  # skull and neck stay still
regions = split_regions(SurfaceGraph(mesh.vertices, mesh.triangles), points, anchors=anchors)
kernel = KERNELS["multiquadric"]
operator = build_operator(mesh.vertices, points, kernel=kernel, epsilon=kernel.epsilon, regions=regions)

# Lower lip and chin move down by 1 cm: one product gives the new face.
displacements = np.zeros((len(points), 3))
for point in CONTROL_POINTS:
    if point.name.startswith(("inner_lip_lower", "outer_lip_lower", "chin")):
        displacements[point.index, 1] = -1.0
offsets = operator.matrix @ displacements

print(f"B has shape {operator.matrix.shape}; the largest offset is {np.abs(offsets).max():.2f} cm")
if len(sys.argv) > 1:
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in mesh.vertices + offsets]
    lines += [f"f {a} {b} {c}" for a, b, c in mesh.triangles + 1]
    Path(sys.argv[1]).write_text("\n".join(lines) + "\n")
