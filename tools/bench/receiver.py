"""Measure the time of each step of the receiver for one frame: medians in milliseconds.

    python tools/bench/receiver.py [--size 640x480] [--callers 1] [--frames 300] [--scale 1.0 | --adapt] [--meter]
        [--cpu] [--json]

Every frame is a codec payload of each caller that is decoded, deforms the default head, is drawn offscreen and read
back; all callers move in every frame. `fps` is the frame rate that the total time allows. Without a GPU the driver is
llvmpipe; LP_NUM_THREADS sets its threads. `--scale` draws the heads with a fraction of the resolution, `--adapt`
chooses resolution and rate as the window does: `scale` and `interval` are those of the last frame. `--cpu` counts the
processor time of all threads instead of the time that passes: on a busy machine it still compares two programs.
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

from conf.face.loading import load_face
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.messages import MotionFrame
from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.receiver.call_stats import CallStats
from conf.receiver.participant_grid import ParticipantGrid
from conf.receiver.resolution_control import DrawingDetail, ResolutionControl
from conf.receiver.stats_overlay import draw_stats
from conf.render.camera import ViewState
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

STEPS = ("decode", "draw", "meter", "read_back")
WARM_UP = 20
TRAFFIC = TrafficSnapshot(900, 3, 1, 900, 0, 60.0, 60.0, 7.2, 230400, 27648.0, 3840.0, 4.1, 67.0)
HISTORY = tuple(MediaBytes(300 + 100 * np.sin(i / 5), 200, 50, 400) for i in range(60))
STATS = CallStats("receiving", 60.0, TRAFFIC, 50, 320, 240, 24.0, HISTORY, 30.0)


def motion(count: int, caller: int) -> list[bytes]:
    """Return coded frames of a nodding head with motion of all control points."""
    rng = np.random.default_rng(7 + caller)
    phases, speeds = rng.uniform(0, 6, (50, 3)), rng.uniform(0.05, 0.3, (50, 3))
    frames = (
        MotionFrame(
            i / 60,
            (40 * np.sin(speeds * i + phases)).astype(np.float32),
            np.array([0.1 * np.sin(i / 15 + caller), 0.3 * np.sin(i / 25 + caller), 0.0, 0.0, -0.03, np.log(0.033)]),
        )
        for i in range(count)
    )
    encoder = Encoder()
    return [encoder.encode([frame], i) for i, frame in enumerate(frames)]


@dataclass(frozen=True)
class Measured:
    """(frames, steps) seconds, the name of the OpenGL driver, the detail of the last frame."""

    times: np.ndarray
    driver: str
    detail: DrawingDetail


def measure(options: argparse.Namespace, size: tuple[int, int]) -> Measured:
    """Draw the frames and measure each step."""
    frames, callers, control = options.frames, range(options.callers), ResolutionControl()
    clock = time.process_time if options.cpu else time.perf_counter
    times = np.zeros((frames, len(STEPS)))
    payloads = [motion(WARM_UP + frames, caller) for caller in callers]
    decoders = [Decoder() for _ in callers]
    view = ViewState(centred=False) if options.callers == 1 else ViewState()
    with OffscreenWindow(*size) as window:
        grid, overlay = ParticipantGrid(window, load_face()), ImGuiOverlay(window.ctx)
        grid.detail = DrawingDetail(scale=options.scale)
        for i in range(WARM_UP + frames):
            times_of_frame = [clock()]
            decoded = [decoder.decode(coded[i], i)[0] for decoder, coded in zip(decoders, payloads, strict=True)]
            motions = {c: MotionFrame(i / 30, frame.displacements, frame.pose) for c, frame in enumerate(decoded)}
            times_of_frame.append(clock())
            window.begin()
            grid.draw(motions, view, i / 30)
            window.end()
            window.finish()
            times_of_frame.append(clock())
            if options.meter:
                with overlay.frame(window):
                    draw_stats(overlay, STATS)
                window.finish()
            times_of_frame.append(clock())
            window.read()
            times_of_frame.append(clock())
            if options.adapt:
                grid.detail = control.on_frame(times_of_frame[3] - times_of_frame[1], cells=options.callers)
            if i >= WARM_UP:
                times[i - WARM_UP] = np.diff(times_of_frame)
        driver = str(window.ctx.info["GL_RENDERER"])
        overlay.release()
        grid.release()
    return Measured(times, driver, grid.detail)


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--size", default="640x480", help="width x height in pixels")
    parser.add_argument("--callers", type=int, default=1)
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
    report |= {"total_ms": round(total * 1e3, 3), "fps": round(1 / total, 1)}
    report |= {"scale": measured.detail.scale, "interval": measured.detail.interval}
    if options.json:
        settings = {"width": width, "height": height, "callers": options.callers, "frames": options.frames}
        print(json.dumps(settings | {"driver": driver, **report}))
        return
    print(f"{width} x {height}, {options.callers} callers, {options.frames} frames, {driver}")
    for name, value in report.items():
        print(f"{name:>14} {value:9.3f}")


if __name__ == "__main__":
    main()
