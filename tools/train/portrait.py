"""Learn what is likely in a portrait: how faces lie, and what patches change. Writes conf/assets/portrait.npz.

    python tools/train/portrait.py TRACKS CLIP... [--check]

TRACKS is a folder of landmark tracks (tools/bench/tracks.py): from them comes how the points of photographs and patches
lie. From the clips comes how patches differ from photographs. --check writes nothing: it tells what each track and clip
costs with a file learned from the others.

Strategy. The points form the tree of least cost: each is told by the one told before that predicts it best, the control
points first, as a neutral pose is told by those alone. Patches are cut as the sender cuts them, and their coefficients
counted at a few steps of the quantiser around those in use.
Source: Prim 1957 (tree of least cost).
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.codec.symbol_coder import SCALES_PER_OCTAVE
from conf.protocol.portrait.patch import MAX_SIDE, POINT_STEPS
from conf.protocol.portrait.probability_model import MODEL_FILE, PointTree, PortraitModel, RegionModel, Steps
from conf.protocol.portrait.shape_coding import POINT_STEP, encode_shape
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.portrait.patch_extraction import find_crop_box
from tools.bench.portrait_patches import PatchCounts, cost_of_patches, count_patches, read_patches
from tools.bench.tracks import StillFace, TrackReader
from tools.train.codec_fit import UNIT_SCALE

FPS = 15.0
SAMPLES = 24  # frames of each track
LEAST_SPREAD = 0.3  # steps: few faces were seen
CONTROLS = len(MEAN_FACE)


@dataclass(frozen=True)
class Poses:
    """Faces of one track.

    points : (N, D, 3) of a photograph; neutral : (N, n, 3) of the neutral pose then in use; both in steps
    patches, keys : for each region (N, m, 2) points of a patch, in its steps, and (N, k) what the region does
    """

    points: Steps
    neutral: Steps
    patches: Sequence[Steps]
    keys: Sequence[Steps]


def read_poses(path: Path, reader: TrackReader) -> Poses:
    """Return the poses of some frames of a track, spread over its length."""
    faces = list(reader.still_faces(path, fps=FPS))
    chosen = [faces[i] for i in np.linspace(0, len(faces) - 1, SAMPLES).astype(int)]
    points = np.array([face.aligned[contours.PORTRAIT_LANDMARKS] for face in chosen])
    neutral = np.array([face.neutral for face in chosen])
    points, neutral = (np.rint(part / POINT_STEP).astype(np.int64) for part in (points, neutral))
    return Poses(
        points,
        neutral,
        [np.array([_patch_points(face, region) for face in chosen]) for region in range(len(FEATURES))],
        [
            np.array([f.quantised_descriptor(face.motion.displacements) for face in chosen]).astype(np.int64)
            for f in FEATURES
        ],
    )


def _patch_points(face: StillFace, region: int) -> Steps:
    centimetre = float(np.exp(face.motion.pose[5])) * face.size[1]
    points = find_crop_box(face.landmarks, FEATURES[region], face.size, px_per_cm=centimetre).points
    return np.rint(points * POINT_STEPS).astype(np.int64)


def learn(tracks: Sequence[Poses], patches: Sequence[PatchCounts]) -> PortraitModel:
    """Learn everything, each track counting the same."""
    stir = np.concatenate([track.neutral - track.points[:, :CONTROLS] for track in tracks])
    regions = [
        RegionModel(
            learn_tree(np.concatenate([track.patches[r] for track in tracks])),
            spread_of(np.concatenate([track.keys[r] for track in tracks])),
        )
        for r in range(len(FEATURES))
    ]
    face = learn_tree(np.concatenate([track.points for track in tracks]), first=CONTROLS)
    return PortraitModel(face, spread_of(stir), regions, sum(patches, PatchCounts()).model())


def learn_tree(points: Steps, *, first: int = 0) -> PointTree:
    """Learn how points (N, D, d) lie. first : so many of them are told before the others."""
    mean = np.rint(points.mean(axis=0)).astype(np.int64)
    off = points - mean
    parents = grow_tree(off, first=first or len(mean))
    order = np.array(list(parents))
    told = off[:, order].copy()
    told[:, 1:] -= off[:, [parents[i] for i in order[1:].tolist()]]
    place = {int(point): at for at, point in enumerate(order)}
    return PointTree(mean, order, np.array([place.get(parents[int(point)], -1) for point in order]), spread_of(told))


def grow_tree(off: Steps, *, first: int) -> dict[int, int]:
    """Return the parent of each point in the order they are told, -1 for the first.

    off : (N, D, d) how each face's points differ from the average; first : so many are told before the others
    """
    cost = np.abs(off[:, :, None] - off[:, None]).mean(axis=0).sum(axis=-1)
    np.fill_diagonal(cost, np.inf)
    parents = {int(np.argmin(np.abs(off[:, :first]).mean(axis=0).sum(axis=-1))): -1}
    for group in (range(first), range(first, len(cost))):
        left = [i for i in group if i not in parents]
        while left:
            known = list(parents)
            row, column = np.unravel_index(np.argmin(cost[np.ix_(left, known)]), (len(left), len(known)))
            parents[left.pop(row)] = known[column]
    return parents


def spread_of(differences: NDArray[np.integer]) -> Steps:
    """Return the scale index (...) that fits differences (N, ...) around zero: that of a logistic distribution."""
    width = np.maximum(np.abs(differences).mean(axis=0), LEAST_SPREAD) / np.log(4)  # of a logistic: mean magnitude
    return np.asarray(np.rint(UNIT_SCALE + SCALES_PER_OCTAVE * np.log2(width)), np.int64)


def cost_of(model: PortraitModel, track: Poses) -> float:
    """Return the mean bytes of a photograph's points and neutral pose."""
    nothing = np.zeros((0, 2), np.int64)
    pairs = zip(track.points, track.neutral, strict=True)
    return float(np.mean([len(encode_shape(points, neutral, nothing, model)) for points, neutral in pairs]))


def main() -> None:
    """Learn and write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tracks", type=Path)
    parser.add_argument("clips", type=Path, nargs="+")
    parser.add_argument("--check", action="store_true", help="what strangers cost; writes nothing")
    options = parser.parse_args()
    reader = TrackReader()
    tracks = {path.stem: read_poses(path, reader) for path in sorted(options.tracks.glob("*.npz"))}
    patches = {path.stem: read_patches(path) for path in options.clips}
    counts = {name: count_patches(some) for name, some in patches.items()}
    if not options.check:
        learn(list(tracks.values()), list(counts.values())).save(MODEL_FILE)
        print(f"{MODEL_FILE.name}: {MODEL_FILE.stat().st_size} bytes, patches up to {MAX_SIDE} px")
        return
    print("bytes of a photograph beside its picture and outline, and of a patch")
    for name in sorted(tracks.keys() | patches.keys()):
        others = [other for key, other in tracks.items() if key != name]
        model = learn(others, [other for key, other in counts.items() if key != name])
        shape = f"{cost_of(model, tracks[name]):6.1f}" if name in tracks else "      "
        print(f"{name:24} {shape}  {cost_of_patches(model, patches[name]) if name in patches else ''}")


if __name__ == "__main__":
    main()
