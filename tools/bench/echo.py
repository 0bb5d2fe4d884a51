"""Measure echo cancellation in simulated rooms: how much echo is left, what double talk costs the near voice, CPU time.

    python tools/bench/echo.py [ROW...] [--rival] [--seed 1] [--seeds 1] [--json]

Speech is that of the GRID clips and the talking clips in the folder `shared/media` beside the repository. Somebody at
the other end talks for 18 s; the near voice begins after 6 s and has three sentences. A row is a scene: room, delay,
level of the echo over the near voice, and what else is wrong. `erle_3s` and `erle_10s` are echo return loss
enhancement, dB, from 3 to 6 s and from 10 s on, while nobody is near; the noise of the room limits them to 46 dB below
an echo as loud as the voice. `converged_s` is the end of the first half second with 20 dB. STOI (Taal, Hendriks,
Heusdens, Jensen 2011) compares with the near voice after a high-pass filter: `stoi_without` is that of the microphone's
sound, `stoi` that of the canceller's, `stoi_loss` what it loses against the near voice alone. `delay_ms` is what the
canceller adds. CPU is processor time in ms for one second of sound.

The rows `clocks +100` and `clocks -100` pass through the alignment of clocks that the program's devices have; the rows
`drift` do not. In the rows `lost` the loudspeaker's buffer runs empty for so long after 8 s, as on a busy machine.
With --seeds N each row is measured N times, with other late reflections, noise and order of the clips; the last line,
and `worst` of --json, have the worst figures of all rows.
--rival measures WebRTC's canceller (pywebrtc-audio) on the same sounds, told the true delay.
"""

import argparse
import json
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray
from pystoi import stoi
from pywebrtc_audio import AudioProcessor

from conf.audio.drift import PLAYED_DROPOUT_S, ClockAligner
from conf.audio.echo_canceller import EchoCanceller
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, to_int16
from conf.sender.capture.clip import read_sound
from tools.bench.rooms import ROOMS, Scene, active_dbfs, room_noise, simulate_echo
from tools.bench.voice_link import align

CLIPS = Path(__file__).resolve().parents[3] / "shared" / "media"
FAR = ("grid_bbaf2n.mpg", "grid_lbax4n.mpg", "grid_pwij3p.mpg", "grid_lbbc2a.mpg", "grid_bbaf2n.mpg", "grid_lbax4n.mpg")
TALK = ("talk_1.mp4", "talk_3.mp4", "talk_4.mp4")
NEAR = ("grid_brbk7n.mpg", "grid_lwbsza.mpg", "grid_swiz3n.mpg")
FAR_DBFS, NEAR_DBFS = -20.0, -26.0
NEAR_FROM_S = 6.0
BLOCK = SAMPLE_RATE // 100  # as devices give it
CONVERGED_DB = 20.0
WINDOW_S = 0.5
MAX_LAG = SAMPLE_RATE // 10
JITTER_S = 0.002  # mean lateness of a device's callback

Block = tuple[AudioBlock, AudioBlock]  # recorded, played
Canceller = Callable[[Samples, Samples, Scene], tuple[Samples, float]]  # -> sound, CPU ms per s


@dataclass(frozen=True)
class Speech:
    """What is said at both ends, (n,) float in int16 units. near begins at near_from, a sample"""

    far: Samples
    near: NDArray[np.float64]
    near_from: int

    @property
    def near_track(self) -> NDArray[np.float64]:
        """The near voice in a track as long as the far one."""
        track = np.zeros(len(self.far))
        track[self.near_from : self.near_from + len(self.near)] = self.near
        return track


@dataclass(frozen=True)
class Row:
    """Figures of one scene. converged_s : None if that did not happen"""

    name: str
    erle_3s: float
    erle_10s: float
    converged_s: float | None
    stoi_without: float
    stoi: float
    stoi_loss: float
    delay_ms: float
    cpu_ms_per_s: float


def scenes() -> dict[str, Scene]:
    """Return the rows by name."""
    rows = {f"{room} {delay_ms} ms": Scene(room, delay_ms / 1000) for room in ROOMS for delay_ms in (20, 60, 120, 200)}
    rows |= {f"office 60 ms, echo {db:+} dB": Scene(echo_db=db) for db in (6, 0, -12)}
    rows |= {f"living 200 ms, echo {db:+} dB": Scene("living", 0.2, echo_db=db) for db in (0, -12)}
    rows |= {f"distortion {level:g}": Scene(distortion=level) for level in (0.5, 1, 2)}
    rows |= {f"drift {ppm:+} ppm": Scene(drift_ppm=ppm) for ppm in (20, 100, -100)}
    rows |= {f"clocks {ppm:+} ppm": Scene(drift_ppm=ppm) for ppm in (0, 100, -100)}
    rows |= {
        "delay 60 to 120 ms at 8 s": Scene(later_delay_s=0.12),
        "delay 200 to 60 ms at 8 s": Scene(delay_s=0.2, later_delay_s=0.06),
        "delay 60 to 61 ms at 8 s": Scene(later_delay_s=0.061),
        "lost 10 ms": Scene(later_delay_s=0.07),
        "lost 30 ms": Scene(later_delay_s=0.09),
        "talking clips": Scene(),
        "near from the start": Scene(),
    }
    return rows


def read_speech(names: tuple[str, ...], dbfs: float) -> NDArray[np.float64]:
    """Return clips one after another, each at a level."""
    parts = []
    for name in names:
        sound = np.concatenate([samples for _, samples in read_sound(CLIPS / name, rate=SAMPLE_RATE)])
        parts.append(sound * 10 ** ((dbfs - active_dbfs(sound)) / 20))
    return np.concatenate(parts)


def high_pass(sound: Samples) -> Samples:
    """Remove the rumble, as conf.audio.processing does."""
    processor = AudioProcessor(SAMPLE_RATE, high_pass_filter=True)
    return np.concatenate([processor.process(block) for block in sound.reshape(-1, BLOCK)])


def cancel(recorded: Samples, played: Samples, scene: Scene) -> tuple[Samples, float]:
    """Run the program's canceller on blocks without jitter."""
    return _run(_cut(recorded, played))


def cancel_on_two_clocks(recorded: Samples, played: Samples, scene: Scene) -> tuple[Samples, float]:
    """Run it on what two sound cards with clocks of their own give, aligned as the program aligns them."""
    rng = np.random.default_rng(2)
    aligners = ClockAligner(), ClockAligner(dropout_s=PLAYED_DROPOUT_S)
    rates = 1 + scene.drift_ppm * 1e-6, 1.0
    blocks = []
    for pair in _cut(recorded, played):
        late = rng.exponential(JITTER_S, 2)
        if scene.later_delay_s is not None and pair[1].timestamp >= scene.change_s:
            late[1] += scene.later_delay_s - scene.delay_s
        stamped = [
            AudioBlock(block.timestamp * rate + lateness, block.samples)
            for block, rate, lateness in zip(pair, rates, late, strict=True)
        ]
        blocks.append((aligners[0].align(stamped[0]), aligners[1].align(stamped[1])))
    return _run(iter(blocks))


def _cut(recorded: Samples, played: Samples) -> Iterator[Block]:
    for first in range(0, len(recorded) - BLOCK + 1, BLOCK):
        at = first / SAMPLE_RATE
        yield (AudioBlock(at, recorded[first : first + BLOCK]), AudioBlock(at, played[first : first + BLOCK]))


def _run(blocks: Iterator[Block]) -> tuple[Samples, float]:
    canceller, parts, seconds = EchoCanceller(), [], 0.0
    for recorded, played in blocks:
        start = time.process_time()
        parts.append(canceller.process(recorded, played).samples)
        seconds += time.process_time() - start
    sound = np.concatenate(parts)
    return sound, 1000 * seconds / (len(sound) / SAMPLE_RATE)


def cancel_as_webrtc(recorded: Samples, played: Samples, scene: Scene) -> tuple[Samples, float]:
    """Run WebRTC's canceller."""
    processor = AudioProcessor(SAMPLE_RATE, echo_cancellation=True, stream_delay_ms=round(1000 * scene.delay_s))
    start = time.process_time()
    pairs = zip(recorded.reshape(-1, BLOCK), played.reshape(-1, BLOCK), strict=True)
    sound = np.concatenate([processor.process(near, far) for near, far in pairs])
    cpu = 1000 * (time.process_time() - start) / (len(sound) / SAMPLE_RATE)
    return sound, cpu


def measure(name: str, scene: Scene, speech: Speech, canceller: Canceller, *, alone: float, seed: int) -> Row:
    """Return the figures of a scene. alone : STOI of the near voice without an echo"""
    echo = simulate_echo(speech.far, scene, dbfs=NEAR_DBFS + scene.echo_db, seed=seed)
    echo += room_noise(len(echo), seed=seed)
    only = to_int16(echo)
    both = to_int16(echo + speech.near_track)
    rest, cpu = canceller(only, speech.far, scene)
    heard, _ = canceller(both, speech.far, scene)
    lag = align(speech.near_track, heard.astype(float), max_samples=MAX_LAG)
    score = _score(speech, heard, lag)
    return Row(
        name=name,
        erle_3s=erle(only, rest, 3.0, NEAR_FROM_S),
        erle_10s=erle(only, rest, 10.0, len(only) / SAMPLE_RATE - 0.5),
        converged_s=converged_s(only, rest),
        stoi_without=_score(speech, both, 0),
        stoi=score,
        stoi_loss=alone - score,
        delay_ms=1000 * lag / SAMPLE_RATE,
        cpu_ms_per_s=cpu,
    )


def erle(before: Samples, after: Samples, start_s: float, stop_s: float) -> float:
    """Return how much quieter the sound is after cancellation, dB."""
    part = slice(round(start_s * SAMPLE_RATE), round(stop_s * SAMPLE_RATE))
    powers = [float(np.square(sound[part].astype(float)).mean()) for sound in (before, after)]
    return float(10 * np.log10(powers[0] / max(powers[1], 1e-3)))


def converged_s(before: Samples, after: Samples) -> float | None:
    """Return the end of the first window with an echo in it that is CONVERGED_DB quieter."""
    for start_s in np.arange(0.0, len(after) / SAMPLE_RATE - WINDOW_S, WINDOW_S / 5):
        window = before[round(start_s * SAMPLE_RATE) : round((start_s + WINDOW_S) * SAMPLE_RATE)]
        is_loud = np.square(window.astype(float)).mean() > 0.1 * np.square(before.astype(float)).mean()
        if is_loud and erle(before, after, start_s, start_s + WINDOW_S) >= CONVERGED_DB:
            return float(start_s + WINDOW_S)
    return None


def _score(speech: Speech, heard: Samples, lag: int) -> float:
    """Return the STOI of the near voice in a sound that lags."""
    reference = high_pass(to_int16(speech.near_track))
    stop = speech.near_from + len(speech.near)
    whole = min(len(reference), len(heard) - lag) // BLOCK * BLOCK
    part = slice(speech.near_from, min(stop, whole))
    filtered = high_pass(heard[lag : lag + whole])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return float(stoi(reference[part].astype(float), filtered[part].astype(float), SAMPLE_RATE))


def score_alone(speech: Speech, canceller: Canceller, seed: int) -> float:
    """Return the STOI of the near voice without an echo in the microphone, with headphones for example."""
    recorded = to_int16(speech.near_track + room_noise(len(speech.far), seed=seed))
    sound, _ = canceller(recorded, speech.far, Scene())
    return _score(speech, sound, align(speech.near_track, sound.astype(float), max_samples=MAX_LAG))


def _print(row: Row) -> None:
    converged = "   -" if row.converged_s is None else f"{row.converged_s:4.1f}"
    print(
        f"{row.name:28} ERLE {row.erle_3s:5.1f} {row.erle_10s:5.1f} dB, 20 dB after {converged} s, "
        f"STOI {row.stoi_without:.3f} -> {row.stoi:.3f} (loss {row.stoi_loss:6.3f}), "
        f"delay {row.delay_ms:4.1f} ms, CPU {row.cpu_ms_per_s:4.1f} ms/s",
        flush=True,
    )


def main() -> None:
    """Print the rows, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="beginnings of names of rows (default: all)")
    parser.add_argument("--rival", action="store_true", help="measure WebRTC's canceller in place of ours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="measure with N seeds, from --seed on")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    chosen = {
        name: scene
        for name, scene in scenes().items()
        if not options.rows or any(name.startswith(row) for row in options.rows)
    }
    if not chosen:
        parser.error(f"there is no such row: choose from {', '.join(scenes())}")
    missing = [name for name in (*FAR, *TALK, *NEAR) if not (CLIPS / name).is_file()]
    if missing:
        print(f"nothing is measured: there is no {missing[0]} in {CLIPS}", file=sys.stderr)
        return
    canceller = cancel_as_webrtc if options.rival else cancel
    rows = []
    for seed in range(options.seed, options.seed + options.seeds):
        for row in measure_all(chosen, canceller, seed):
            rows.append(row)
            if not options.json:
                _print(row)
    if options.json:
        print(json.dumps({"rows": [asdict(row) for row in rows], "worst": worst(rows)}))
    else:
        print("worst: " + ", ".join(f"{name} {value:.3f}" for name, value in worst(rows).items()))


def measure_all(chosen: dict[str, Scene], canceller: Canceller, seed: int) -> Iterator[Row]:
    """Yield the rows of scenes. seed : of late reflections, noise and, from 2 on, the order of the clips"""
    far, near, talk = (
        read_speech(_rotated(names, seed - 1), dbfs)
        for names, dbfs in ((FAR, FAR_DBFS), (NEAR, NEAR_DBFS), (TALK, FAR_DBFS))
    )
    length = len(far) // BLOCK * BLOCK
    grid = Speech(to_int16(far[:length]), near, round(NEAR_FROM_S * SAMPLE_RATE))
    speeches = {
        "talking clips": Speech(to_int16(np.tile(talk, 2)[:length]), near, grid.near_from),
        "near from the start": Speech(grid.far, near, 0),
    }
    alone: dict[int, float] = {}
    for name, scene in chosen.items():
        speech = speeches.get(name, grid)
        if id(speech) not in alone:
            alone[id(speech)] = score_alone(speech, canceller, seed)
        on_clocks = name.startswith(("clocks", "lost")) and canceller is cancel
        used = cancel_on_two_clocks if on_clocks else canceller
        yield measure(name, scene, speech, used, alone=alone[id(speech)], seed=seed)


def _rotated(names: tuple[str, ...], count: int) -> tuple[str, ...]:
    first = count % len(names)
    return names[first:] + names[:first]


def worst(rows: list[Row]) -> dict[str, float]:
    """Return the worst figures of all rows."""
    figures = {
        "erle_3s": min(row.erle_3s for row in rows),
        "erle_10s": min(row.erle_10s for row in rows),
        "stoi_loss": max(row.stoi_loss for row in rows),
    }
    converged = [row.converged_s for row in rows if row.converged_s is not None]
    return figures | ({"converged_s": max(converged)} if len(converged) == len(rows) else {})


if __name__ == "__main__":
    main()
