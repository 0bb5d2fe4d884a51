"""Measure how well the drawn face follows the person: track a clip, send it, draw it, track the drawing, compare.

    python tools/bench/fidelity.py CLIP [--face FACE.obj] [--pictures FOLDER] [--json]

The clip passes through the whole path, datagrams included, in simulated time, so that each drawing has its frame. The
curves that are compared are those of tools/bench/rate_curves.py on the tracked drawing, then those of
tools/bench/expression_curves.py at three stages: the vertices of the head without the codec (the ceiling), the vertices
that are drawn, and the tracked drawing. The tracker reads a drawn face with a bias of its own, vertices have none.
"""

import argparse
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.furrows import knit_brows, skin_furrows
from conf.face.head_pose import HeadPose
from conf.face.loading import load_face
from conf.protocol.codec.profiles import LIVE
from conf.protocol.loopback import ONE_WAY_S, LoopbackCall
from conf.protocol.messages import StreamParameters
from conf.protocol.rate_control.send_budget import RateOptions
from conf.render.auto_framing import AutoFraming
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.clip import open_clip
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion.furrows import FurrowEstimator
from conf.sender.tracking.canonical_face import load_canonical_face, remove_head_pose
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker
from tools.bench.expression_curves import REPORTED
from tools.bench.fidelity_tracks import DrawnHead, compare_curves, landmark_points, pair_cell, relative_pupils
from tools.bench.rate_curves import CURVES, compare, face_curves

SIZE = (480, 480)
MIN_SPREAD = {  # standard deviation of a curve on the person, below which it is the tracker's noise
    "mouth_opening": 0.01, "mouth_width": 0.01, "lid_right": 0.006, "lid_left": 0.006,
    "brow_inner": 0.006, "brow_outer": 0.006, "yaw": 1.0, "pitch": 1.0, "roll": 1.0,
}  # fmt: skip


@dataclass(frozen=True)
class Pair:
    """One frame of the person and its drawing, each with its curves.

    timestamp : of the frame, s
    landmarks : (478, 3) of the person, px
    aligned, drawn : (478, 3) landmarks of the person, and of the drawing if a face was found, head pose removed
    ceiling, vertices : (n, 3) positions of the head's vertices, of the motion before the codec and of what is drawn
    """

    pixels: NDArray[np.uint8]
    drawing: NDArray[np.uint8]
    source: dict[str, float]
    shown: dict[str, float] | None
    aligned: NDArray[np.float64]
    drawn: NDArray[np.float64] | None
    ceiling: NDArray[np.float64]
    vertices: NDArray[np.float64]
    timestamp: float
    landmarks: NDArray[np.float32]


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--face", type=Path, help="mesh of another face, with its PPC in the same folder")
    parser.add_argument("--pictures", type=Path, help="write person and drawing side by side into this folder")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    pairs = list(run(options.clip, options.face))
    result = summary(pairs)
    if options.pictures:
        write_images(pairs, options.pictures)
    print(json.dumps(result) if options.json else table(result, pairs))


def run(clip: Path, face_path: Path | None = None, *, size: tuple[int, int] = SIZE) -> Iterator[Pair]:
    """Yield every frame with a face, with its drawing of a width and height, px."""
    models = fetch_models()
    canonical = load_canonical_face()
    face = load_face(face_path)
    head = DrawnHead(face)
    source_tracker, drawing_tracker = FaceTracker(models), FaceTracker(models)
    with open_clip(clip) as source, OffscreenWindow(*size) as window:
        renderer = FaceRenderer(window.ctx, face)
        extractor = MotionExtractor(canonical, source.size)
        furrows = FurrowEstimator()
        parameters = StreamParameters(*source.size, source.fps, 50, astuple(extractor.fapu))
        call = LoopbackCall(parameters, 0.0, os.urandom, rate=RateOptions(LIVE.name))
        pace, framer, view = FramePacer(LIVE.fps), AutoFraming(), ViewState()
        for frame in iter(source.read, None):
            tracking = source_tracker.track(frame.pixels)
            now = frame.timestamp
            if tracking is None or pace.delay_for(now, now) is None:
                continue
            sent = furrows.add_furrows(extractor.update(tracking, now), tracking, frame.pixels)
            call.send_frame(sent, now)
            delay = call.stream.snapshot(now).playout_delay_ms / 1000
            playout = call.stream.motion.frame_at(now + ONE_WAY_S + delay + 1e-3)
            if playout is None:
                continue
            pose = framer.frame(HeadPose.from_vector(playout.frame.pose), now)
            window.begin()
            shown_motion = knit_brows(playout.frame.displacements, playout.frame.furrow)
            deformed = face.deform(shown_motion, sender=extractor.fapu)
            folds = skin_furrows(shown_motion, playout.frame.furrow)
            renderer.draw(deformed, pose, view, window.framebuffer, furrows=folds)
            window.end()
            drawing = window.read()
            found = drawing_tracker.track(drawing)
            aligned, source_pose = remove_head_pose(tracking.landmarks, canonical, source.size)
            shown, drawn = None, None
            if found is not None:
                drawn, drawn_pose = remove_head_pose(found.landmarks, canonical, size)
                shown = face_curves(drawn, drawn_pose)
            ceiling, vertices = (
                head.draw(motion, extractor.fapu)[0] for motion in (sent.displacements, playout.frame.displacements)
            )
            source_curves = face_curves(aligned, source_pose)
            curves = (source_curves, shown)
            yield Pair(frame.pixels, drawing, *curves, aligned, drawn, ceiling, vertices, now, tracking.landmarks)
        renderer.release()


def summary(pairs: list[Pair]) -> dict[str, dict[str, Any]]:
    """Return correlation and gain of each curve; None for a curve that the person does not move."""
    tracked_pairs = [(pair.source, pair.shown) for pair in pairs if pair.shown is not None]
    result: dict[str, dict[str, Any]] = {}
    for name in CURVES:
        source = np.array([a[name] for a, _ in tracked_pairs])
        shown = np.array([b[name] for _, b in tracked_pairs])
        moves = source.std() >= MIN_SPREAD[name]
        correlation, gain = compare(source, shown)
        result[name] = {
            "correlation": round(correlation, 3) if moves else None,
            "gain": round(gain, 3) if moves else None,
            "source_spread": round(float(source.std()), 4),
        }
    return result | {"lids_when_shut": closed_lids(tracked_pairs), "stages": expression_stages(pairs)}


def expression_stages(pairs: list[Pair]) -> dict[str, dict[str, tuple[float, float] | None]]:
    """Return correlation and gain of each curve of expressions at each stage."""
    aligned = np.stack([pair.aligned for pair in pairs])
    stages = {
        "ceiling": compare_curves(aligned, relative_pupils(np.stack([p.ceiling for p in pairs])), bridge=True),
        "vertices": compare_curves(aligned, relative_pupils(np.stack([p.vertices for p in pairs])), bridge=True),
    }
    if both := [(pair.aligned, pair.drawn) for pair in pairs if pair.drawn is not None]:
        person, drawing = (np.stack(arrays) for arrays in zip(*both, strict=True))
        stages["tracked drawing"] = compare_curves(person, landmark_points(drawing, bridge=True), bridge=True)
    return stages


def closed_lids(tracked_pairs: list[tuple[dict[str, float], dict[str, float]]]) -> dict[str, float | None]:
    """Return the smallest eyelid gap, relative to its median, of person and drawing in frames with closed eyes."""
    source = np.array([[a["lid_right"], a["lid_left"]] for a, _ in tracked_pairs]).mean(axis=1)
    shown = np.array([[b["lid_right"], b["lid_left"]] for _, b in tracked_pairs]).mean(axis=1)
    median_gap = np.median(source)
    closed = source < 0.5 * median_gap
    if not closed.any():
        return {"source": None, "shown": None}
    return {
        "source": round(float(source[closed].min() / median_gap), 3),
        "shown": round(float(shown[closed].min() / np.median(shown)), 3),
    }


def table(result: dict[str, dict[str, Any]], pairs: list[Pair]) -> str:
    """Return the result as a table."""
    lines = [f"{'curve':<16}{'correlation':>12}{'gain':>8}{'spread':>9}"]
    for name in CURVES:
        row = result[name]
        lines.append(f"{name:<16}{_cell(row['correlation']):>12}{_cell(row['gain']):>8}{row['source_spread']:>9}")
    lids = result["lids_when_shut"]
    lines.append(
        f"smallest eyelid gap: person {_cell(lids['source'])}, drawing {_cell(lids['shown'])} of the median gap"
    )
    stages = result["stages"]
    lines.append(f"\n{'expression':<22}" + "".join(f"{stage:>18}" for stage in stages))
    for name in REPORTED:
        lines.append(f"{name:<22}" + "".join(f"{pair_cell(stage[name]):>18}" for stage in stages.values()))
    lost = sum(pair.shown is None for pair in pairs)
    lines.append(f"{len(pairs)} frames, {lost} drawings in which the tracker found no face")
    return "\n".join(lines)


def _cell(value: float | None) -> str:
    return "still" if value is None else f"{value:.3f}"


def write_images(pairs: list[Pair], folder: Path) -> None:
    """Write person and drawing side by side at the extremes of each curve and in nine evenly spaced frames."""
    folder.mkdir(parents=True, exist_ok=True)
    selected = set(np.linspace(0, len(pairs) - 1, 9).astype(int).tolist())
    for name in CURVES:
        values = [pair.source[name] for pair in pairs]
        selected |= {int(np.argmax(values)), int(np.argmin(values))}
    for index in sorted(selected):
        person = pairs[index].pixels
        scale = SIZE[1] / person.shape[0]
        person = cv2.resize(person, (round(person.shape[1] * scale), SIZE[1]))
        cv2.imwrite(str(folder / f"{index:05}.jpg"), np.hstack([person, pairs[index].drawing]))


if __name__ == "__main__":
    main()
