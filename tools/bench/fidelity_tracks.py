"""Measure how well the drawn head's vertices follow tracked landmarks, without drawing: seconds for all tracks.

    python tools/bench/fidelity_tracks.py [TRACK.npz...] [--face FACE.obj] [--leave-out] [--json]

Without a track, all of shared/motion. With --leave-out, what an expression explains is learned from the other tracks
of shared/motion (tools/train/expression.py). The curves are those of tools/bench/expression_curves.py. Each is
compared with the landmarks, head pose removed, at four stages: points before the codec, points after it, and the
vertices of the head at the control points, without and with the codec. Brows of vertices are measured from the vertex
at the bridge of the nose and compared with landmarks measured from there: on both it follows the brows by a quarter
to a third. The control points have no bridge, and brows are sent to fit that of the head: those of points are
compared, as all else of them, where the head pose puts them. The result is the median over the tracks whose person
moves.
"""

import argparse
import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.errors import ConfError
from conf.face.control_points import CONTROL_POINT_LANDMARKS, EYE_CORNERS, PUPILS, control_point_indices
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.fapu import Fapu
from conf.face.loading import load_face
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.profiles import PROFILES
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import NeutralPoseEstimator
from tools.bench.expression_curves import BRIDGE_LANDMARK, REPORTED, reported_curves
from tools.bench.rate_curves import compare
from tools.bench.tracks import Track, TrackReader
from tools.train.expression import Sample, fit_map, quiet_weights, read_sample

MOTION = Path(__file__).resolve().parents[3] / "shared" / "motion"
STAGES = ("points", "points after the codec", "vertices without codec", "vertices")
ACK_DELAY = 2  # frames
# Standard deviation of a curve on the person, eye distances, below which it is the tracker's noise. The noise
# itself, that of a track's quietest half seconds without their slope, is 0.001 to 0.002, that of the mouth's opening
# and width 0.003 to 0.004.
MIN_SPREAD = {"mouth opening": 0.01, "mouth width": 0.01, "knit": 0.004}
DEFAULT_SPREAD = 0.006
CLOSED_CM = 0.1  # from lip to lip, of a mouth that counts as closed
OPEN_EYE = 0.6  # of the head's neutral slit
_VERTEX_TOLERANCE = 0.15  # cm by which a point's vertex may be farther from it than the nearest one
_BRIDGE_HEIGHT = 0.26  # of the way from the inner corners of the eyes up to the brows, mean of the tracks
_BRIDGE_WIDTH_CM = 0.4  # around it, within which its vertex is looked for
_BROWS = control_point_indices("brow")
_INNER_BROWS, _INNER_CORNERS = control_point_indices("brow_inner"), control_point_indices("eye_inner_corner")
_MIDDLE_LIPS = control_point_indices("inner_lip_upper_mid", "inner_lip_lower_mid")
_LIDS = list(zip(control_point_indices("eyelid_upper"), control_point_indices("eyelid_lower"), strict=True))
_INNER_LIPS = control_point_indices("inner_lip_upper", "inner_lip_lower")


@dataclass(frozen=True)
class Comparison:
    """One track's figures.

    curves : stage and curve -> correlation and gain, None for a curve that the person does not move
    closed, opened : frames with a closed mouth, and how many of them are drawn open by more than CLOSED_CM
    eyes, hidden : eyes drawn with lids more than OPEN_EYE open, and how many of them do not show their pupil
    """

    curves: dict[str, dict[str, tuple[float, float] | None]]
    closed: int
    opened: int
    eyes: int
    hidden: int


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("tracks", nargs="*", type=Path, metavar="TRACK.npz")
    parser.add_argument("--profile", choices=PROFILES, default="live")
    parser.add_argument("--face", type=Path, help="mesh of another face, with its PPC in the same folder")
    parser.add_argument("--leave-out", action="store_true", help="learn neutral poses without each track's person")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    reader, fps = TrackReader(), PROFILES[options.profile].fps
    try:
        head = DrawnHead(load_face(options.face))
        results = {}
        samples = [read_sample(reader, path) for path in sorted(MOTION.glob("*.npz"))] if options.leave_out else []
        for path in options.tracks or sorted(MOTION.glob("*.npz")):
            neutral = neutral_without(path.stem, samples) if samples else None
            track = reader.read(path, fps=fps, neutral=neutral)
            results[path.stem] = compare_track(track, head, profile=options.profile)
    except (OSError, ConfError) as error:
        sys.exit(str(error))
    print(json.dumps(summary(results), indent=2) if options.json else table(results))


def neutral_without(name: str, samples: Sequence[Sample]) -> NeutralPoseEstimator:
    """Return an estimator whose map from expressions to offsets is learned from the samples of another name."""
    others = [sample for sample in samples if sample.name != name]
    weights, quiet = fit_map(others), quiet_weights(others)
    return NeutralPoseEstimator(lambda shapes: np.asarray(((shapes - quiet) @ weights).reshape(-1, 3)))


class DrawnHead:
    """A head and, for each control point, the vertex that shows it."""

    def __init__(self, face: FaceModel) -> None:
        self.face = face
        self._lips = LipOpening(face)
        tree = KDTree(face.mesh.vertices)
        self._vertices = np.asarray(tree.query(face.control_points)[1]).tolist()
        for point in _INNER_LIPS:  # where lips touch, the nearest vertex may be the other one's
            position = face.control_points[point]
            near = np.sort(tree.query_ball_point(position, tree.query(position)[0] + _VERTEX_TOLERANCE))
            self._vertices[point] = int(near[face.operator[near, point].argmax()])
        for eye in () if face.rig is None else face.rig.eyes:
            distances = np.linalg.norm(face.mesh.vertices[eye.vertices] - face.control_points[eye.pupil], axis=1)
            self._vertices[eye.pupil] = int(eye.vertices[distances.argmin()])
        corners, brows = (face.control_points[points].mean(axis=0) for points in (_INNER_CORNERS, _INNER_BROWS))
        bridge = corners + _BRIDGE_HEIGHT * (brows - corners)
        around = tree.query_ball_point(bridge, _BRIDGE_WIDTH_CM + tree.query(bridge)[0])
        self.bridge: int = min(around, key=lambda vertex: abs(face.mesh.vertices[vertex, :2] - bridge[:2]).sum())

    def draw(self, displacements: NDArray[np.floating], sender: Fapu, /) -> tuple[NDArray[np.float64], float]:
        """Return the (n, 3) positions at the control points, cm, and the distance from lip to lip, cm.

        Brows are relative to the bridge of the nose.
        """
        vertices = self.face.deform(displacements, sender=sender)
        positions = vertices[self._vertices].astype(np.float64)
        positions[_BROWS] -= vertices[self.bridge]
        return positions, self._lips.measure(vertices)


def compare_track(
    track: Track, head: DrawnHead, /, *, profile: str = "live", models: Mapping[str, CodecModel] | None = None
) -> Comparison:
    """Return a track's figures: each stage compared with the landmarks."""
    sent = np.stack([frame.displacements for frame in track.frames]).astype(np.float64)
    received = code_track(track, profile=profile, models=models)
    sender = track.fapu
    drawn = [[head.draw(frame, sender) for frame in motion] for motion in (sent, received)]
    positions = [
        MEAN_FACE + sent * track.lengths,
        MEAN_FACE + received * track.lengths,
        *(relative_pupils(np.stack([points for points, _ in frames])) for frames in drawn),
    ]
    curves = {
        stage: compare_curves(track.aligned, points, bridge="vertices" in stage)
        for stage, points in zip(STAGES, positions, strict=True)
    }
    upper, lower = _MIDDLE_LIPS
    closed = track.aligned[:, CONTROL_POINT_LANDMARKS[upper], 1] - track.aligned[:, CONTROL_POINT_LANDMARKS[lower], 1]
    openings = np.array([opening for _, opening in drawn[1]])
    is_closed = closed < CLOSED_CM
    eyes, hidden = count_hidden_irises(np.stack([points for points, _ in drawn[1]]), head.face.control_points)
    return Comparison(curves, int(is_closed.sum()), int((openings[is_closed] > CLOSED_CM).sum()), eyes, hidden)


def count_hidden_irises(points: NDArray[np.float64], neutral: NDArray[np.float64], /) -> tuple[int, int]:
    """Return how many eyes are open, and of these whose pupil is not between lids and corners.

    points : (N, n, 3) as drawn; neutral : (n, 3) of the same head
    """
    is_open, is_hidden = [], []
    for pupil, corners, lids in zip(PUPILS, EYE_CORNERS, _LIDS, strict=True):
        upper, lower = points[:, lids, 1].T
        is_open.append(upper - lower > OPEN_EYE * float(neutral[lids[0], 1] - neutral[lids[1], 1]))
        x, y, _ = points[:, pupil].T
        ends = np.sort(points[:, corners, 0], axis=1)
        is_hidden.append((y <= lower) | (y >= upper) | (x <= ends[:, 0]) | (x >= ends[:, 1]))
    return int(np.sum(is_open)), int(np.sum(np.logical_and(is_open, is_hidden)))


def compare_curves(
    aligned: NDArray[np.float64], shown: NDArray[np.float64], /, *, bridge: bool
) -> dict[str, tuple[float, float] | None]:
    """Return correlation and gain of each curve, None for a curve that the person does not move.

    aligned : (N, 478, 3) landmarks of the person, head pose removed
    shown : (N, n, 3) what is compared, as `reported_curves` asks
    bridge : compare with brows relative to the bridge of the nose, else with brows as the head pose places them
    """
    source, drawn = reported_curves(landmark_points(aligned, bridge=bridge)), reported_curves(shown)
    return {
        name: compare(a, b) if a.std() >= MIN_SPREAD.get(name, DEFAULT_SPREAD) else None
        for name, a, b in zip(REPORTED, source.T, drawn.T, strict=True)
    }


def code_track(
    track: Track, /, *, profile: str = "live", models: Mapping[str, CodecModel] | None = None
) -> NDArray[np.float64]:
    """Return the (N, n, 3) displacements after the codec, each frame acknowledged ACK_DELAY frames later."""
    encoder, decoder = Encoder(PROFILES[profile], models), Decoder(models)
    received: list[NDArray[np.float32]] = []
    size = PROFILES[profile].frames_per_datagram
    for number in range(0, len(track.frames), size):
        encoder.acknowledge(range(max(0, number - ACK_DELAY + 1)))
        payload = encoder.encode(track.frames[number : number + size], number)
        received += [frame.displacements for frame in decoder.decode(payload, number)]
    return np.stack(received).astype(np.float64)


def landmark_points(aligned: NDArray[np.float64], /, *, bridge: bool) -> NDArray[np.float64]:
    """Return control points (N, n, 3) of landmarks (N, 478, 3) with the head pose removed, as reported_curves asks.

    bridge : brows relative to the bridge of the nose
    """
    points = aligned[:, CONTROL_POINT_LANDMARKS]
    if bridge:
        points[:, _BROWS] -= aligned[:, BRIDGE_LANDMARK, None]
    return relative_pupils(points)


def relative_pupils(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return control points (N, n, 3), pupils relative to the middle of the corners of their eye."""
    relative = points.copy()
    for pupil, corners in zip(PUPILS, EYE_CORNERS, strict=True):
        relative[:, pupil] -= points[:, corners].mean(axis=1)
    return relative


def summary(results: Mapping[str, Comparison]) -> dict[str, object]:
    """Return medians over the tracks, and each track's figures."""
    return {
        "median": {stage: {name: _median(results, stage, name) for name in REPORTED} for stage in STAGES},
        "max_gain": {name: _max_gain(results, name) for name in REPORTED},
        "closed_frames": sum(result.closed for result in results.values()),
        "closed_frames_drawn_open": sum(result.opened for result in results.values()),
        "open_eyes": sum(result.eyes for result in results.values()),
        "open_eyes_with_a_hidden_pupil": sum(result.hidden for result in results.values()),
        "tracks": {name: result.curves for name, result in results.items()},
    }


def _values(results: Mapping[str, Comparison], stage: str, name: str) -> list[tuple[float, float]]:
    return [value for result in results.values() if (value := result.curves[stage][name]) is not None]


def _median(results: Mapping[str, Comparison], stage: str, name: str) -> tuple[float, float] | None:
    values = _values(results, stage, name)
    if not values:
        return None
    correlation, gain = np.nanmedian(values, axis=0).tolist()
    return round(correlation, 3), round(gain, 3)


def _max_gain(results: Mapping[str, Comparison], name: str) -> float | None:
    gains = [gain for _, gain in _values(results, "vertices", name)]
    return round(float(np.nanmax(gains)), 3) if gains else None


def table(results: Mapping[str, Comparison]) -> str:
    """Return the medians as a table."""
    lines = [f"{'curve':<22}" + "".join(f"{stage:>24}" for stage in STAGES) + f"{'max gain':>10}{'tracks':>8}"]
    for name in REPORTED:
        cells = "".join(f"{pair_cell(_median(results, stage, name)):>24}" for stage in STAGES)
        count = len(_values(results, STAGES[0], name))
        lines.append(f"{name:<22}{cells}{_max_gain(results, name) or float('nan'):>10.2f}{count:>8}")
    keys = ("closed", "opened", "eyes", "hidden")
    closed, opened, eyes, hidden = (sum(getattr(result, key) for result in results.values()) for key in keys)
    lines.append(f"closed mouth: {closed} frames, {opened} drawn open by more than {CLOSED_CM * 10:.0f} mm")
    lines.append(f"eyes more than {100 * OPEN_EYE:.0f} % open: {eyes}, {hidden} with a hidden pupil")
    return "\n".join(lines)


def pair_cell(value: tuple[float, float] | None) -> str:
    """Return correlation and gain for a table; a dash for a curve that does not move."""
    return "-" if value is None else f"{value[0]:.2f} / {value[1]:.2f}"


if __name__ == "__main__":
    main()
