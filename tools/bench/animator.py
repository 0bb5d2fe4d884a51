"""Measure how fast the animator's window draws a large face: at rest, moving, and while B is rebuilt repeatedly.

    xvfb-run -a python tools/bench/animator.py [--vertices 20000] [--frames 200] [--size 1280x800] [--json]

The face is the default head cut to --vertices vertices and opened from a file, as a user's mesh is. `rest` is idle
motion only (blinks, sway), `moving` plays an emotion, `changing` requests another kernel and locality as soon as the
last operator B is finished; `build_ms` is the time of those builds. Times are milliseconds of a whole frame of the
window, display included. `*_cpu_ms` is the processor time of all threads, which does not depend on other load. Without
a display the frames are drawn offscreen; waiting for them holds Python's global lock, so that a build takes three times
as long as beside a window. Without a GPU the driver is llvmpipe.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count, cycle
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.animator.app import AnimatorApp
from conf.animator.face_document import FaceDocument, open_face_document
from conf.errors import GraphicsError
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.rbf import KERNELS
from conf.face.formats.obj import RawMesh
from conf.face.formats.ppc import write_ppc
from conf.face.mesh.mesh import build_mesh
from conf.output.obj_writer import write_obj
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.offscreen import OffscreenWindow
from tools.bench.deformation import head_of

WARM_UP = 20


def large_face(folder: Path, vertices: int) -> FaceDocument:
    """Return the default head cut to so many vertices, opened from an OBJ with its PPC as a user's mesh is."""
    head = open_face_document()
    assert head.points is not None
    positions, triangles = head_of(head.mesh, vertices)
    corners = np.stack([triangles, np.full_like(triangles, -1)], axis=-1).astype(np.int64)
    path = folder / "face.obj"
    mesh = build_mesh(RawMesh(positions, np.zeros((0, 2)), corners, {}, None))
    write_obj(path, mesh, positions)
    write_ppc(path.with_suffix(".ppc"), head.points)
    return open_face_document(path)


def open_window(size: tuple[int, int]) -> GlfwWindow | OffscreenWindow:
    """Return a window on the display, or an offscreen window if there is no display."""
    try:
        return GlfwWindow(*size, "bench animator")
    except GraphicsError:
        return OffscreenWindow(*size)


def deformers() -> Iterator[DeformerOptions]:
    """Yield deformer settings, each with another kernel and another locality than the one before."""
    for name, step in zip(cycle(KERNELS), count()):
        yield DeformerOptions(name, epsilon=0.3 + 0.1 * (step % 10))


class Bench:
    """One animator whose frames are timed."""

    def __init__(self, window: GlfwWindow | OffscreenWindow, subject: FaceDocument) -> None:
        self._window = window
        self.animator = AnimatorApp(window, subject)
        self._settings = deformers()
        self.builds: list[float] = []
        self.frames(WARM_UP)

    def frames(self, number: int, between: Callable[[], None] = lambda: None) -> dict[str, float]:
        """Draw so many frames and return minimum, median, 95th percentile, maximum and processor time, ms a frame."""
        wall = np.zeros(number)
        cpu = time.process_time()
        for i in range(number):
            start = time.perf_counter()
            self.animator.draw_frame()
            self._window.finish()
            wall[i] = time.perf_counter() - start
            between()
        cpu = time.process_time() - cpu
        minimum, median, p95, maximum = 1e3 * np.quantile(wall, [0.0, 0.5, 0.95, 1.0])
        return {"min": minimum, "median": median, "p95": p95, "max": maximum, "cpu": 1e3 * cpu / number}

    def change(self) -> None:
        """Request another B if the last one is finished."""
        controller = self.animator.controller
        if not controller.face.busy:
            self.builds.append(controller.face.build_ms)
            controller.state = replace(controller.state, deformer=next(self._settings))


def measure(window: GlfwWindow | OffscreenWindow, subject: FaceDocument, frames: int) -> dict[str, float]:
    """Return the figures of `rest`, `moving` and `changing`."""
    bench = Bench(window, subject)
    report: dict[str, float] = {}
    try:
        report |= named("rest", bench.frames(frames))
        bench.animator.controller.play_expression("joy", bench.animator.now())
        report |= named("moving", bench.frames(frames))
        report |= named("changing", bench.frames(frames, bench.change))
    finally:
        bench.animator.close()
    builds = bench.builds[2:]  # the first is of no change, the second also computes the regions
    report |= {"build_median_ms": round(float(np.median(builds)), 1), "build_max_ms": round(max(builds), 1)}
    return report | {"builds": len(builds)}


def named(state: str, figures: dict[str, float]) -> dict[str, float]:
    """Return the figures with the names they are printed under."""
    return {f"{state}_{name}_ms": round(float(value), 2) for name, value in figures.items()}


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vertices", type=int, default=20_000)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--size", default="1280x800", help="width x height of the window in pixels")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    with tempfile.TemporaryDirectory() as folder, open_window((width, height)) as window:
        driver = str(window.ctx.info["GL_RENDERER"])
        report = measure(window, large_face(Path(folder), options.vertices), options.frames)
    facts = {"width": width, "height": height, "vertices": options.vertices, "driver": driver}
    if options.json:
        print(json.dumps(facts | report))
        return
    for name, value in (facts | report).items():
        print(f"{name.replace('_', ' '):>22}  {value}")


if __name__ == "__main__":
    main()
