"""Train the motion codec: the learned space, the pose steps, the context weights and the tables.

    python tools/train/codec.py [--motion FOLDER] [--output FILE] [--base FILE] [--folds K]

Strategy. Four parts are trained on facial motion tracks. Each model is simple, because there are only three minutes of
motion and the result must generalise to other people.

1. The learned space. The error of a frame is d' M d with the error d of its displacements and the metric
   M = diag(w^2) + curve_weight / n G' G: w weights each coordinate by the visibility of an error (LIP_WEIGHT, the
   space's vertical weights, DEPTH), and the rows of G are the gradients of curves that describe an expression
   (tools/bench/expression_curves.py). Viewers read expressions from differences of points, which are smaller than the
   points' motion: a frown moves the brows towards each other by 2 mm. Displacements times the square root of M are
   projected on their principal directions. A step in any direction then causes the same error, so one step size serves
   all directions, as rate-distortion theory requires (reverse water-filling). Directions with little motion cost almost
   nothing. One step of each pose value moves the points of a mean face by the space's pose_step, in steps.
2. The default reference, used when there is no reference: the mean over people of each person's median.
3. The context weights: the expected size of a difference, given the age of the reference and the values coded before
   (conf/protocol/codec/syntax.py). Fitted for each value and each of the AGES.
4. The tables: the frequency of each difference at each scale. And what the decoder adds to each value
   (conf/protocol/codec/reconstruction.py), fitted to what is usual: references two frames old, or none.

3 and 4 are trained on the codec's own output: the tracks are coded with every age of reference, and features and
differences are recorded. The encoder's choices depend on the tables, so this is done twice, from uniform contexts.

Files in HELD_OUT are never trained on; the report and tools/bench/codec.py measure with them. With --folds the training
is repeated with each K-th part of all files held out in turn, so that every track is measured with tables that were not
trained on it. The result is deterministic.

Validity of the figures. The tables were not trained on the tracks they are measured with, but the settings (steps,
lambda, number of components, staggered values) were chosen by the figures of the folds over all tracks, which include
HELD_OUT; it is also one of the easier parts. Over all 25 tracks in five folds `live` takes 4.43 B per frame at 0.88 %
and 1.94 % (95th percentile) with acknowledgements two frames old, 9.38 B at 0.91 % and 2.04 % without any. The fold
with pose_s29 and talk_7 is the hardest: 1.12 %, 2.64 % and 11.5 B. A lasting smile or bent head costs its bits again in
each frame without reference. Quote the figures of all folds together.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import control_point_indices
from conf.protocol.codec.encoder import INTER_LAMBDA_FACTOR, code_frame
from conf.protocol.codec.model import CodecModel, build_models
from conf.protocol.codec.profiles import LIVE, PROFILES, Profile
from conf.protocol.codec.reconstruction import HISTORY
from conf.protocol.codec.reference_frames import LOG_SCALE, POSE_VALUES, QuantisedFrame
from conf.protocol.codec.symbol_coder import SymbolWriter, Tables
from conf.protocol.codec.syntax import FEATURE_COUNT, LOG_ONE, Context
from tools.bench.codec_link import HELD_OUT, Link, measure, total
from tools.bench.tracks import Track, TrackReader
from tools.train.codec_fit import fit_reconstruction, fit_tables, fit_weights, predict_scales
from tools.train.codec_space import AGES, FINE, SPACE, Arrays, fit_shared, fit_space

REPOSITORY = Path(__file__).resolve().parents[2]
MOTION = REPOSITORY.parent / "shared" / "motion"
OUTPUT = REPOSITORY / "conf" / "assets" / "codec.npz"

ROUNDS = 2
TRAINED = [profile for profile in PROFILES.values() if profile.tables == profile.name]

Tracks = Mapping[float, Sequence[Track]]  # by frames a second


def train(tracks: Tracks, /, *, base: Arrays | None = None) -> Arrays:
    """Return the arrays of the codec's file.

    base : arrays of another file; only the space and the profile live are trained, all else is kept

    analysis : (3 n, K) FAPU units to components, eye distances; synthesis : (K, 3 n) components to FAPU units
    pose_unit : (6,) log scale, radians, face sizes for a step of one eye distance
    coupling, stagger, opening, correction, middle, usual_log_scale : see WIRE.md
    ages : (A,); for each profile weights (1 + 2 A, 6 + K, F), frequencies, standing (6 + K,), growth; lean (6 + K,),
        history (2, 6 + K, 6 + K): see conf/protocol/codec/reconstruction.py
    """
    arrays = fit_shared(tracks[min(tracks)]) if base is None else dict(base)
    trained = TRAINED if base is None else [LIVE]
    arrays |= fit_space(SPACE, tracks[min(tracks)])
    for profile in trained:
        arrays |= uniform_statistics(profile, arrays)
    for _ in range(ROUNDS):
        models = build_models(arrays)
        for model in (models[profile.name] for profile in trained):
            arrays |= fit_statistics(model, tracks[model.profile.fps])
    return arrays


def uniform_statistics(profile: Profile, arrays: Arrays, /) -> Arrays:
    """Return the statistics of a profile before training: all contexts are equal."""
    count = POSE_VALUES + SPACE.components
    weights = np.zeros((1 + 2 * len(AGES), count, FEATURE_COUNT), dtype=np.int16)
    weights[:, :, 0] = 12 * LOG_ONE
    weights[0, :POSE_VALUES, 0] = 40 * LOG_ONE
    nothing = np.zeros(0, dtype=np.int64)
    return {
        f"{profile.name}_weights": weights,
        f"{profile.name}_frequencies": fit_tables(nothing, nothing),
        f"{profile.name}_standing": np.zeros(count, dtype=np.int16),
        **_reconstruction(profile.name, np.zeros((1 + HISTORY * count, count))),
        f"{profile.name}_growth": np.array(round(65536 * profile.step * float(arrays["pose_unit"][0])), dtype=np.int32),
    }


@dataclass(frozen=True)
class RecordingModel(CodecModel):
    """A model that records the features that it is called with."""

    recorded: list[tuple[int, ...]] = field(default_factory=list)

    def scale(self, row: int, index: int, features: tuple[int, ...]) -> int:
        """Record the features and return the model's scale."""
        self.recorded.append(features)
        return super().scale(row, index, features)


class RecordingWriter(SymbolWriter):
    """A writer that records its numbers."""

    def __init__(self, *, rd_lambda: float) -> None:
        super().__init__(rd_lambda=rd_lambda)
        self.numbers: list[int] = []

    def number(self, tables: Tables, scale: int, target: float) -> int:
        """Write a number and record it."""
        self.numbers.append(super().number(tables, scale, target))
        return self.numbers[-1]


@dataclass(frozen=True)
class Observations:
    """The statistics of all tracks, coded with one age of reference.

    features : (M, 6 + K, F); differences : (M, 6 + K)
    values : (N, 6 + K) of coded frames, dequantised
    earlier : (N, HISTORY, 6 + K) the same of the frames before each
    errors : (N, 6 + K) steps from each coded frame to the exact values
    medians : (T, 6 + K) of the tracks
    """

    features: NDArray[np.int64]
    differences: NDArray[np.int64]
    values: NDArray[np.float64]
    earlier: NDArray[np.float64]
    errors: NDArray[np.float64]
    medians: NDArray[np.float64]


def fit_statistics(model: CodecModel, tracks: Sequence[Track], /) -> Arrays:
    """Return the arrays of one profile, fitted to the tracks as coded with the given model."""
    weights = np.array(model.weights, dtype=np.int16)
    scales, differences = [], []
    plain = {age: observe(model, tracks, age, second=False) for age in (0, *AGES)}
    with_second = {age: observe(model, tracks, age, second=True) for age in AGES}
    rows = [(model.rows[age], observed) for age, observed in plain.items()]
    rows += [(model.second_reference_rows[age], observed) for age, observed in with_second.items()]
    for row, observed in rows:
        for value in range(weights.shape[1]):
            features, difference = observed.features[:, value], observed.differences[:, value]
            weights[row, value] = fit_weights(features, difference)
            scales.append(predict_scales(weights[row, value], features))
            differences.append(difference)
    usual, name = (plain[0], plain[2]), model.profile.name
    corrections = fit_reconstruction(
        *(np.concatenate([getattr(observed, part) for observed in usual]) for part in ("values", "earlier", "errors"))
    )
    return {
        f"{name}_weights": weights,
        f"{name}_frequencies": fit_tables(np.concatenate(scales), np.concatenate(differences)),
        f"{name}_standing": np.rint(plain[0].medians.mean(axis=0)).astype(np.int16),
        **_reconstruction(name, corrections),
    }


def observe(model: CodecModel, tracks: Sequence[Track], age: int, *, second: bool) -> Observations:
    """Code each track with references `age` ticks old, with or without second references."""
    recorder = RecordingModel(**{f.name: getattr(model, f.name) for f in fields(model)})
    features, differences, shown, earlier, errors, medians = [], [], [], [], [], []
    rd_lambda = model.profile.rd_lambda * (INTER_LAMBDA_FACTOR if age else 1.0)
    for track in tracks:
        coded: list[QuantisedFrame] = []
        for number, frame in enumerate(track.frames):
            recorder.recorded.clear()
            writer = RecordingWriter(rd_lambda=rd_lambda)
            context = _context(model, coded, age, second=second)
            coded.append(code_frame(writer, recorder, context, frame)[0])
            if number >= age + second:  # earlier frames have no such reference
                features.append(list(recorder.recorded))
                differences.append(writer.numbers)
        values = np.array([model.transform.dequantise(frame) for frame in coded])
        shown.append(values[HISTORY:])
        earlier.append(np.stack([values[HISTORY - back : -back] for back in range(1, HISTORY + 1)], axis=1))
        errors.append(_errors(model, track, coded, values)[HISTORY:])
        medians.append(np.median(values, axis=0))
    return Observations(
        np.array(features),
        np.array(differences),
        np.concatenate(shown),
        np.concatenate(earlier),
        np.concatenate(errors),
        np.array(medians),
    )


def _errors(
    model: CodecModel, track: Track, coded: list[QuantisedFrame], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    transform = model.transform
    exact = [
        transform.forward(frame.displacements, frame.pose, log_scale=quantised.values[LOG_SCALE])
        for frame, quantised in zip(track.frames, coded, strict=True)
    ]
    errors = np.array(exact) - values
    errors[:, POSE_VALUES:] += transform.compensate_pose_error(errors[:, :POSE_VALUES])
    return np.asarray(errors)


def _reconstruction(name: str, coefficients: NDArray[np.float64]) -> Arrays:
    """Return the arrays of coefficients (1 + HISTORY * V, V)."""
    count = coefficients.shape[1]
    return {
        f"{name}_lean": coefficients[0].astype(np.float16),
        f"{name}_history": coefficients[1:].reshape(HISTORY, count, count).astype(np.float16),
    }


def _context(model: CodecModel, coded: list[QuantisedFrame], age: int, *, second: bool) -> Context:
    if not 0 < age <= len(coded):
        return Context(model.rows[0], replace(model.default_reference, staggered=len(coded) % 2 == 1))
    if second and age < len(coded):
        return Context(model.second_reference_rows[age], coded[-age], coded[-age - 1])
    return Context(model.rows[age], coded[-age])


def read_tracks(folder: Path, /) -> dict[float, list[Track]]:
    """Return all tracks of a folder at the frame rates of the profiles."""
    reader = TrackReader()
    rates = sorted({profile.fps for profile in TRAINED})
    return {fps: [reader.read(path, fps=fps) for path in sorted(folder.glob("*.npz"))] for fps in rates}


def write(arrays: Arrays, path: Path, /) -> None:
    """Write the file atomically."""
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".npz", delete=False) as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


LINKS = {
    "live, acknowledged 2 frames ago": ("live", Link(ack_delay=2)),
    "live, 4": ("live", Link(ack_delay=4)),
    "live, 8": ("live", Link(ack_delay=8)),
    "live, never": ("live", Link(ack_delay=0)),
    "narrow, 4": ("narrow", Link(ack_delay=4)),
    "narrow, never": ("narrow", Link(ack_delay=0)),
    "rich, 8": ("rich", Link(ack_delay=8)),
    "rich, never": ("rich", Link(ack_delay=0)),
}


def report(title: str, parts: Sequence[tuple[Arrays, Tracks]], /) -> None:
    """Print bytes and errors of tracks, each part coded with its own arrays."""
    print(f"\n{title}\n{'link':34}{'B/frame':>8}{'kbit/s':>8}{'mean %':>8}{'95 % %':>8}{'fine %':>8}{'coarse %':>9}")
    built = [(build_models(arrays), tracks) for arrays, tracks in parts]
    for name, (profile, link) in LINKS.items():
        results = [
            measure(track, PROFILES[profile], link, models=models)
            for models, tracks in built
            for track in tracks[PROFILES[profile].fps]
        ]
        result = total(results)
        fine = result.errors[:, control_point_indices(*FINE)].mean()
        coarse = np.delete(result.errors, control_point_indices(*FINE), axis=1).mean()
        print(
            f"{name:34}{result.payload_bytes_per_frame:8.2f}{result.kbps:8.2f}{result.error_mean_percent:8.3f}"
            f"{result.error_p95_percent:8.3f}{fine:8.3f}{coarse:9.3f}",
            flush=True,
        )


def select(tracks: Tracks, names: set[str], /, *, inside: bool) -> dict[float, list[Track]]:
    """Return the tracks whose name is in `names`, or is not."""
    return {fps: [track for track in group if (track.name in names) == inside] for fps, group in tracks.items()}


def main() -> None:
    """Train, write the file and report on the held-out tracks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--motion", type=Path, default=MOTION, help="folder of facial motion tracks")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    parser.add_argument("--base", type=Path, help="train only live; keep the other profiles of this file")
    parser.add_argument("--folds", type=int, default=0, help="number of folds of a cross-validation over all tracks")
    arguments = parser.parse_args()
    tracks = read_tracks(arguments.motion)
    held_out = set(HELD_OUT)
    base = None
    if arguments.base:
        with np.load(arguments.base) as file:
            base = {name: file[name] for name in file.files}
    arrays = train(select(tracks, held_out, inside=False), base=base)
    write(arrays, arguments.output)
    print(f"{arguments.output}: {arguments.output.stat().st_size} bytes")
    report(f"held out: {', '.join(HELD_OUT)}", [(arrays, select(tracks, held_out, inside=True))])
    if arguments.folds:
        names = [track.name for track in tracks[min(tracks)]]
        folds = [set(names[start :: arguments.folds]) for start in range(arguments.folds)]
        parts = [
            (train(select(tracks, out, inside=False), base=base), select(tracks, out, inside=True)) for out in folds
        ]
        report(f"all {len(names)} tracks, {arguments.folds} folds", parts)


if __name__ == "__main__":
    main()
