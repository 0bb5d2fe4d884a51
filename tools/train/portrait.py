"""Train the statistics of portraits: point trees and block tables. Writes conf/assets/portrait.npz.

    python tools/train/portrait.py TRACKS CLIP... [--check]

TRACKS is a folder of landmark tracks (tools/bench/tracks.py): they give the statistics of the points of photos and
patches. The clips give those of the coefficients of patches. --check writes nothing: it prints the cost of each track
and clip with a model trained on the others.

Strategy. The points form a minimum spanning tree: each is predicted from the earlier point that predicts it best. The
control points come first, because a neutral pose consists of them alone. Patches are extracted as by the sender, and
their coefficients are counted at a few quantiser steps around those in use.
Source: Prim 1957 (minimum spanning tree).
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
from conf.protocol.portrait.probability_model import (
    BLOCK_ARRAYS,
    MODEL_FILE,
    REGIONS,
    TREE_ARRAYS,
    PointTree,
    PortraitModel,
    RegionModel,
    Steps,
)
from conf.protocol.portrait.shape_coding import POINT_STEP, encode_shape
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.portrait.patch_extraction import find_crop_box
from tools.bench.tracks import StillFace, TrackReader
from tools.train.codec_fit import UNIT_SCALE
from tools.train.portrait_patches import PatchCounts, cost_of_patches, count_patches, read_patches

FPS = 15.0
SAMPLES = 24  # frames of each track
MIN_MAGNITUDE = 0.3  # steps, because there are few training faces
CONTROLS = len(MEAN_FACE)


@dataclass(frozen=True)
class Poses:
    """Faces of one track.

    points : (N, D, 3) of a photo; neutral : (N, n, 3) of the neutral pose at that time; both in steps
    patches, descriptors : for each region (N, m, 2) points of a patch in its steps, and (N, k) its descriptor
    """

    points: Steps
    neutral: Steps
    patches: Sequence[Steps]
    descriptors: Sequence[Steps]


def read_poses(path: Path, reader: TrackReader) -> Poses:
    """Return the faces of SAMPLES evenly spaced frames of a track."""
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
    _, _, points = find_crop_box(face.landmarks, FEATURES[region], face.size, px_per_cm=centimetre)
    return np.rint(points * POINT_STEPS).astype(np.int64)


def train(tracks: Sequence[Poses], patches: Sequence[PatchCounts]) -> PortraitModel:
    """Return the model; every track has the same weight."""
    differences = np.concatenate([track.neutral - track.points[:, :CONTROLS] for track in tracks])
    regions = [
        RegionModel(
            fit_tree(np.concatenate([track.patches[r] for track in tracks])),
            fit_scale(np.concatenate([track.descriptors[r] for track in tracks])),
        )
        for r in range(len(FEATURES))
    ]
    face = fit_tree(np.concatenate([track.points for track in tracks]), first=CONTROLS)
    return PortraitModel(face, fit_scale(differences), regions, sum(patches, PatchCounts()).model())


def model_arrays(model: PortraitModel) -> dict[str, NDArray[np.int16]]:
    """Return the arrays of the file, by name."""
    named = dict(zip(REGIONS, model.regions, strict=True))
    arrays = {"stir_spread": model.neutral_difference_scale}
    arrays |= {f"{name}_key_spread": region.descriptor_scale for name, region in named.items()}
    for name, tree in {"face": model.face, **{name: region.points for name, region in named.items()}}.items():
        fields = (tree.mean, tree.order, tree.parents, tree.scale)
        arrays |= {f"{name}_{key}": array for key, array in zip(TREE_ARRAYS, fields, strict=True)}
    blocks = (model.blocks.coded, model.blocks.last, model.blocks.coefficient_scale)
    arrays |= dict(zip(BLOCK_ARRAYS, blocks, strict=True))
    return {name: array.astype(np.int16) for name, array in arrays.items()}


def fit_tree(points: Steps, *, first: int = 0) -> PointTree:
    """Return the tree of points (N, D, d). first : number of points that are coded before the others"""
    mean = np.rint(points.mean(axis=0)).astype(np.int64)
    deviations = points - mean
    parents = spanning_tree(deviations, first=first or len(mean))
    order = np.array(list(parents))
    differences = deviations[:, order].copy()
    differences[:, 1:] -= deviations[:, [parents[i] for i in order[1:].tolist()]]
    index = {int(point): i for i, point in enumerate(order)}
    parent_indices = np.array([index.get(parents[int(point)], -1) for point in order])
    return PointTree(mean, order, parent_indices, fit_scale(differences))


def spanning_tree(deviations: Steps, *, first: int) -> dict[int, int]:
    """Return the parent of each point in coding order, -1 for the first.

    deviations : (N, D, d) from the mean; first : number of points that are coded before the others
    """
    cost = np.abs(deviations[:, :, None] - deviations[:, None]).mean(axis=0).sum(axis=-1)
    np.fill_diagonal(cost, np.inf)
    parents = {int(np.argmin(np.abs(deviations[:, :first]).mean(axis=0).sum(axis=-1))): -1}
    for group in (range(first), range(first, len(cost))):
        remaining = [i for i in group if i not in parents]
        while remaining:
            known = list(parents)
            row, column = np.unravel_index(np.argmin(cost[np.ix_(remaining, known)]), (len(remaining), len(known)))
            parents[remaining.pop(row)] = known[column]
    return parents


def fit_scale(differences: NDArray[np.integer]) -> Steps:
    """Return the scale index (...) of a logistic distribution around zero that fits differences (N, ...)."""
    # The mean magnitude of a logistic distribution is log(4) times its width.
    width = np.maximum(np.abs(differences).mean(axis=0), MIN_MAGNITUDE) / np.log(4)
    return np.asarray(np.rint(UNIT_SCALE + SCALES_PER_OCTAVE * np.log2(width)), np.int64)


def cost_of(model: PortraitModel, track: Poses) -> float:
    """Return the mean bytes of a photo's points and neutral pose."""
    no_outline = np.zeros((0, 2), np.int64)
    pairs = zip(track.points, track.neutral, strict=True)
    return float(np.mean([len(encode_shape(points, neutral, no_outline, model)) for points, neutral in pairs]))


def main() -> None:
    """Train and write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tracks", type=Path)
    parser.add_argument("clips", type=Path, nargs="+")
    parser.add_argument(
        "--check", action="store_true", help="print costs with models of the other tracks; write nothing"
    )
    options = parser.parse_args()
    reader = TrackReader()
    tracks = {path.stem: read_poses(path, reader) for path in sorted(options.tracks.glob("*.npz"))}
    patches = {path.stem: read_patches(path) for path in options.clips}
    counts = {name: count_patches(some) for name, some in patches.items()}
    if not options.check:
        path = Path(str(MODEL_FILE))
        with path.open("wb") as file:
            np.savez(file, allow_pickle=False, **model_arrays(train(list(tracks.values()), list(counts.values()))))
        print(f"{path.name}: {path.stat().st_size} bytes, patches up to {MAX_SIDE} px")
        return
    print("bytes of a photo without its image and outline, and of a patch")
    for name in sorted(tracks.keys() | patches.keys()):
        others = [other for key, other in tracks.items() if key != name]
        model = train(others, [other for key, other in counts.items() if key != name])
        shape = f"{cost_of(model, tracks[name]):6.1f}" if name in tracks else "      "
        print(f"{name:24} {shape}  {cost_of_patches(model, patches[name]) if name in patches else ''}")


if __name__ == "__main__":
    main()
