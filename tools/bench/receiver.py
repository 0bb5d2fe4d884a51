"""Measure the time of each step of the receiver for one frame: medians in milliseconds.

    python tools/bench/receiver.py [--size 640x480] [--frames 300] [--scale 1.0 | --adapt] [--meter] [--cpu] [--json]

Every frame is a codec payload that is decoded, deforms the default head, is drawn offscreen and read back. `fps` is the
frame rate that the total time allows. Without a GPU the driver is llvmpipe; LP_NUM_THREADS sets its threads.
`--scale` draws the head with a fraction of the resolution, `--adapt` chooses it as the window does: `scale` is that of
the last frame. `--cpu` counts the processor time of all threads instead of the time that passes: on a busy machine
it still compares two programs.
"""

import argparse
import json
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.loading import load_face
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.messages import MotionFrame
from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.receiver.call_stats import CallStats
from conf.receiver.resolution_control import ResolutionControl
from conf.receiver.stats_overlay import draw_stats
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

STEPS = ("decode", "deform", "draw", "meter", "read_back")
WARM_UP = 20
TRAFFIC = TrafficSnapshot(900, 3, 1, 900, 0, 60.0, 60.0, 7.2, 230400, 27648.0, 3840.0, 4.1, 67.0)
HISTORY = tuple(MediaBytes(300 + 100 * np.sin(i / 5), 200, 50, 400) for i in range(60))
STATS = CallStats("receiving", 60.0, TRAFFIC, 50, 320, 240, 24.0, HISTORY, 30.0)


def motion(count: int) -> list[bytes]:
    """Return coded frames of a nodding head with motion of all control points."""
    rng = np.random.default_rng(7)
    phases, speeds = rng.uniform(0, 6, (50, 3)), rng.uniform(0.05, 0.3, (50, 3))
    frames = (
        MotionFrame(
            i / 60,
            (40 * np.sin(speeds * i + phases)).astype(np.float32),
            np.array([0.1 * np.sin(i / 15), 0.3 * np.sin(i / 25), 0.0, 0.0, -0.03, np.log(0.033)]),
        )
        for i in range(count)
    )
    encoder = Encoder()
    return [encoder.encode([frame], i) for i, frame in enumerate(frames)]


@dataclass(frozen=True)
class Measured:
    """(frames, steps) seconds, the name of the OpenGL driver, the scale of the last frame."""

    times: np.ndarray
    driver: str
    scale: float


def measure(options: argparse.Namespace, size: tuple[int, int]) -> Measured:
    """Draw the frames and measure each step."""
    face, frames, control = load_face(), options.frames, ResolutionControl()
    clock = time.process_time if options.cpu else time.perf_counter
    times = np.zeros((frames, len(STEPS)))
    with OffscreenWindow(*size) as window:
        renderer, overlay = FaceRenderer(window.ctx, face), ImGuiOverlay(window.ctx)
        renderer.scale = options.scale
        vertices, decoder = face.neutral.copy(), Decoder()
        for i, data in enumerate(motion(WARM_UP + frames)):
            times_of_frame = [clock()]
            (frame,) = decoder.decode(data, i)
            times_of_frame.append(clock())
            face.deform(frame.displacements, out=vertices)
            times_of_frame.append(clock())
            pose = HeadPose.from_vector(frame.pose)
            window.begin()
            renderer.draw(vertices, pose, ViewState(), window.framebuffer)
            window.end()
            window.ctx.finish()
            times_of_frame.append(clock())
            if options.meter:
                with overlay.frame(window):
                    draw_stats(overlay, STATS)
                window.ctx.finish()
            times_of_frame.append(clock())
            window.read()
            times_of_frame.append(clock())
            if options.adapt:
                renderer.scale = control.on_frame(times_of_frame[4] - times_of_frame[1])
            if i >= WARM_UP:
                times[i - WARM_UP] = np.diff(times_of_frame)
        driver = str(window.ctx.info["GL_RENDERER"])
        scale = renderer.scale
        overlay.release()
        renderer.release()
    return Measured(times, driver, scale)


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--size", default="640x480", help="width x height in pixels")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--meter", action="store_true", help="draw the statistics overlay too")
    scaling = parser.add_mutually_exclusive_group()
    scaling.add_argument("--scale", type=float, default=1.0, help="of the resolution in which the head is drawn")
    scaling.add_argument("--adapt", action="store_true", help="adapt that scale to the drawing time")
    parser.add_argument("--cpu", action="store_true", help="count processor time")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    measured = measure(options, (width, height))
    times, driver = measured.times, measured.driver
    total = float(np.median(times.sum(axis=1)))
    report = {f"{name}_ms": round(float(ms), 3) for name, ms in zip(STEPS, np.median(times, axis=0) * 1e3, strict=True)}
    report |= {"total_ms": round(total * 1e3, 3), "fps": round(1 / total, 1), "scale": measured.scale}
    if options.json:
        print(json.dumps({"width": width, "height": height, "frames": options.frames, "driver": driver, **report}))
        return
    print(f"{width} x {height}, {options.frames} frames, {driver}")
    for name, value in report.items():
        print(f"{name:>14} {value:9.3f}")


if __name__ == "__main__":
    main()
