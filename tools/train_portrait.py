"""Learn how a photographed face usually lies: what its points cost to send. Writes conf/assets/portrait.npz.

    python tools/train_portrait.py TRACKS [--check]

TRACKS is a folder of landmark tracks (tools/tracks.py). --check writes nothing: it tells what the points of each track
cost with a file learned from the others.

Strategy. Points next to each other differ from the average face's in nearly the same way. So each point is told by how
its difference from the average differs from that of one point told before, the one that predicts it best: the points
form the tree of least cost, the control points first, as a neutral pose is told by those alone.
Source: Prim 1957 (tree of least cost).
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from conf.face.portrait import contours
from conf.protocol.codec.symbols import SCALES_AN_OCTAVE
from conf.protocol.portrait.face_shape import FACE_FILE, POINT_STEP, FaceModel, encode_shape
from conf.sender.mean_face import MEAN_FACE
from tools.codec_fit import UNIT_SCALE
from tools.tracks import TrackReader

FPS = 15.0
SAMPLES = 24  # frames of each track
LEAST_SPREAD = 0.3  # steps: few faces were seen
CONTROLS = len(MEAN_FACE)

Steps = NDArray[np.int64]


@dataclass(frozen=True)
class Poses:
    """Faces of one track, in steps: (N, D, 3) the points of a photograph, (N, n, 3) of the neutral pose then in use."""

    points: Steps
    neutral: Steps


def read_poses(path: Path, reader: TrackReader) -> Poses:
    """Return the poses of some frames of a track, spread over its length."""
    faces = list(reader.still_faces(path, fps=FPS))
    chosen = [faces[i] for i in np.linspace(0, len(faces) - 1, SAMPLES).astype(int)]
    points = np.array([face.landmarks[contours.ALL] for face in chosen])
    neutral = np.array([face.neutral for face in chosen])
    return Poses(*(np.rint(part / POINT_STEP).astype(np.int64) for part in (points, neutral)))


def learn(tracks: Sequence[Poses]) -> FaceModel:
    """Learn average, tree and spread, each track counting the same."""
    points = np.concatenate([track.points for track in tracks])
    stir = np.concatenate([track.neutral - track.points[:, :CONTROLS] for track in tracks])
    mean = np.rint(points.mean(axis=0)).astype(np.int64)
    parents = grow_tree(points - mean)
    order = np.array(list(parents))
    off = points - mean
    told = off[:, order].copy()
    told[:, 1:] -= off[:, [parents[i] for i in order[1:].tolist()]]
    place = {int(point): at for at, point in enumerate(order)}
    return FaceModel(
        mean=mean,
        order=order,
        parents=np.array([place.get(parents[int(point)], -1) for point in order]),
        spread=spread_of(told),
        stir_spread=spread_of(stir),
    )


def grow_tree(off: Steps) -> dict[int, int]:
    """Return the parent of each point in the order they are told, -1 for the first; the control points come first.

    off : (N, D, 3) how each face's points differ from the average
    """
    cost = np.abs(off[:, :, None] - off[:, None]).mean(axis=0).sum(axis=-1)
    np.fill_diagonal(cost, np.inf)
    parents = {int(np.argmin(np.abs(off[:, :CONTROLS]).mean(axis=0).sum(axis=-1))): -1}
    for group in (range(CONTROLS), range(CONTROLS, len(cost))):
        left = [i for i in group if i not in parents]
        while left:
            known = list(parents)
            row, column = np.unravel_index(np.argmin(cost[np.ix_(left, known)]), (len(left), len(known)))
            parents[left.pop(row)] = known[column]
    return parents


def spread_of(differences: Steps) -> Steps:
    """Return the scale index (D, 3) that fits differences (N, D, 3) around zero: that of a logistic distribution."""
    width = np.maximum(np.abs(differences).mean(axis=0), LEAST_SPREAD) / np.log(4)  # of a logistic: mean magnitude
    return np.asarray(np.rint(UNIT_SCALE + SCALES_AN_OCTAVE * np.log2(width)), np.int64)


def cost_of(model: FaceModel, track: Poses) -> float:
    """Return the mean bytes of a photograph's points and neutral pose."""
    nothing = np.zeros((0, 2), np.int64)
    pairs = zip(track.points, track.neutral, strict=True)
    return float(np.mean([len(encode_shape(points, neutral, nothing, model)) for points, neutral in pairs]))


def main() -> None:
    """Learn and write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tracks", type=Path)
    parser.add_argument("--check", action="store_true", help="what strangers' faces cost; writes nothing")
    options = parser.parse_args()
    reader = TrackReader()
    tracks = {path.stem: read_poses(path, reader) for path in sorted(options.tracks.glob("*.npz"))}
    if options.check:
        costs = []
        for name, track in tracks.items():
            others = [other for other_name, other in tracks.items() if other_name != name]
            costs.append(cost_of(learn(others), track))
            print(f"{name:24} {costs[-1]:6.1f} B")
        print(f"{'mean':24} {np.mean(costs):6.1f} B")
        return
    learn(list(tracks.values())).save(FACE_FILE)
    print(f"{FACE_FILE.name}: {FACE_FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
