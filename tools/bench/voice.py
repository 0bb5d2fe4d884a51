"""Measure voice and face together at each link rate: rate, intelligibility, error of the face, delay, CPU time.

    python tools/bench/voice.py [CLIP...] [--rates 16 9.6 6 4.8 2.4] [--loss 0 0.05 0.1 0.2] [--seconds 30]
        [--skew] [--devices] [--json]

Without clips, the talking clips of ../shared/media whose tracks are in ../shared/motion. Calls are simulated
(voice_link.py): everything but the network and the clock is the program's. Beside the losses: 10 % in bursts of three,
and 5 and 20 % without repetition ("plain"), where a level repeats. Beside the rates: Opus 6000 in RTP, voice alone.

STOI (Taal, Hendriks, Heusdens, Jensen 2011) compares what is heard with what the microphone captured, after the
high-pass filter that the processing of the microphone applies. The GRID clips have rumble within 40 dB of the speech,
which STOI counts as speech: silence between words costs .07 against the raw sound and nothing against the filtered
one. The pauses of talk_1 are room noise that loud: not to send them costs .2 even against the filtered sound, and
nothing against the filtered sound without its pauses. In brackets: without pauses, and against the raw sound. Before
the calls of a rate, what its codec reaches alone: the filtered sound, encoded and decoded without processing, gaps and
network.

--skew adds the lip sync of real calls over loopback (lip_sync.py), with the GRID clips among the clips, without loss
and at 10 %. It takes 20 s for each clip, rate and loss, and needs a quiet machine. --devices adds the delay of real
calls through a sound server (voice_devices.py): half a minute for each rate.

--json does all of it, with the table on the error output, and prints an object by rate:

kbps, face_error_percent, face_fps, cpu_ms_per_s : without loss
worst_kbps : of any ten seconds, whatever is lost
stoi, stoi_loss5, stoi_loss10, stoi_loss20, stoi_bursts10, stoi_plain5, stoi_plain20 : as in the table; null for what
    --loss leaves out, and for plain where a level repeats nothing
skew_ms : without loss or at 10 %, whichever is further from 0; plus is sound that is early; null without GRID clips
delay_ms : from microphone to loudspeaker, less the datagram's own duration, through PulseAudio's null sink; without
    PulseAudio as in the table: without devices

Calls that fail, as on a machine that is too busy, are made once more; the figure is null if they fail again.
"""

import argparse
import json
import os
import shutil
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from pystoi import stoi
from pywebrtc_audio import AudioProcessor

from conf.audio.codecs.registry import create_decoder, create_encoder
from conf.audio.processing import BLOCK_SAMPLES
from conf.audio.samples import SAMPLE_RATE, Samples
from conf.protocol.rate_control.rate_levels import VoiceMode, levels_for
from conf.protocol.rate_control.send_budget import highest_level
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.voice.formats import VoiceFormat
from conf.sender.capture.clip import read_sound
from tools.bench.lip_sync import measure_skew
from tools.bench.tracks import Track, TrackReader
from tools.bench.voice_devices import measure_delays
from tools.bench.voice_link import ONE_WAY_S, SETTLE_S, Loss, VoiceCall, align, call

SHARED = Path(__file__).resolve().parents[3] / "shared"
GRID = ("bbaf2n", "brbk7n", "lbax4n", "lbbc2a", "lwbsza", "pwij3p", "swiz3n")
CLIPS = [SHARED / "media" / f"grid_{name}.mpg" for name in GRID]
CLIPS += [SHARED / "media" / f"talk_{number}.mp4" for number in (1, 3, 4)]
RATES = (16.0, 9.6, 6.0, 4.8, 2.4)
LOSSES = (0.0, 0.05, 0.1, 0.2)
NO_LOSS = Loss()
FPS = 30.0
RTP_BYTES = 12
SKEW_CALL_S = 10.0  # of each real call: three times a GRID clip
PIECE_S = 3.0  # of sound with one alignment
ABOVE_BACKGROUND_DB, BELOW_SPEECH_DB = 6.0, 20.0
MAX_LAG = int(1.5 * SAMPLE_RATE)


@dataclass(frozen=True)
class Condition:
    """What a call meets. is_plain : nothing is repeated, all that is lost is concealed"""

    loss: Loss = NO_LOSS
    is_plain: bool = False

    def __str__(self) -> str:
        bursts = f" in bursts of {self.loss.burst}" if self.loss.burst > 1 else ""
        return f"loss {self.loss.fraction:.0%}{bursts}{', plain' if self.is_plain else ''}"


CLEAN, LOSS10, BURSTS = Condition(), Condition(Loss(0.1)), Condition(Loss(0.1, 3))
PLAIN = Condition(Loss(0.05), is_plain=True), Condition(Loss(0.2), is_plain=True)
STOI_KEYS = {
    "stoi": CLEAN,
    "stoi_loss5": Condition(Loss(0.05)),
    "stoi_loss10": LOSS10,
    "stoi_loss20": Condition(Loss(0.2)),
    "stoi_bursts10": BURSTS,
    "stoi_plain5": PLAIN[0],
    "stoi_plain20": PLAIN[1],
}


class Scores(NamedTuple):
    """STOI against the filtered sound, against the same without its pauses, and against the raw sound."""

    filtered: float
    speech: float
    raw: float


class Measured(NamedTuple):
    """A call with one clip, without its sound. delay_s : from microphone to ear"""

    made: VoiceCall
    scores: Scores
    delay_s: float


@dataclass(frozen=True)
class Figures:
    """Of one rate and loss, over all clips.

    face_fps : while the face moves: from the median interval of the received frames. One that does not move is not sent
    delay_ms : from microphone to ear, less the network and the datagram
    """

    kbps: float
    worst_kbps: float
    scores: Scores
    face_error_percent: float
    face_fps: float
    delay_ms: float
    cpu_ms_per_s: float


def main() -> None:
    """Print the table, and at the end the object if it is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clips", nargs="*", type=Path, default=CLIPS, metavar="CLIP")
    parser.add_argument("--rates", nargs="+", type=float, default=RATES, metavar="KBPS")
    parser.add_argument("--loss", nargs="+", type=float, default=LOSSES, metavar="FRACTION", help="of the table")
    parser.add_argument("--seconds", type=float, default=30.0, help="duration of each call; clips are repeated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--skew", action="store_true", help="measure the lip sync of real calls")
    parser.add_argument("--devices", action="store_true", help="measure the delay through a sound server")
    parser.add_argument("--json", action="store_true", help="measure all and print an object")
    arguments = parser.parse_args()
    rates, show = arguments.rates, partial(print, file=sys.stderr if arguments.json else sys.stdout, flush=True)
    with ProcessPoolExecutor() as pool:
        figures = {rate: _table(pool, rate, arguments, show) for rate in rates}
    for packet, score in _opus_in_rtp([read_subject(clip)[1] for clip in arguments.clips]):
        show(f"Opus 6000 in RTP, {packet[1]} ms, no face: {packet[0]:.1f} kbit/s, STOI {score:.3f}")
    delays: dict[float, float | None] = {rate: figures[rate][CLEAN].delay_ms for rate in rates}
    if arguments.devices or (arguments.json and shutil.which("pulseaudio")):
        delays = measure_delays(rates)
        for rate, delay_ms in delays.items():
            show(f"{rate:5g} kbit/s through a sound server: delay {delay_ms} ms")
    skews = {}
    if (arguments.skew or arguments.json) and (grid := [clip for clip in arguments.clips if _is_grid(clip)]):
        skews = {rate: _skew(grid, rate, show) for rate in rates}
    if arguments.json:
        found = {f"{rate:g}": summary(figures[rate], skews.get(rate), delays[rate]) for rate in rates}
        print(json.dumps(found, indent=2))


def summary(
    figures: Mapping[Condition, Figures], skew_ms: float | None, delay_ms: float | None
) -> dict[str, float | None]:
    """Return one rate's object of --json."""
    clean = figures[CLEAN]
    return {
        "kbps": clean.kbps,
        "worst_kbps": max(found.worst_kbps for found in figures.values()),
        **{key: figures[at].scores.filtered if at in figures else None for key, at in STOI_KEYS.items()},
        "face_error_percent": clean.face_error_percent,
        "face_fps": clean.face_fps,
        "skew_ms": skew_ms,
        "delay_ms": delay_ms,
        "cpu_ms_per_s": clean.cpu_ms_per_s,
    }


def _is_grid(path: Path) -> bool:
    return path.stem.startswith("grid_")


def _skew(clips: list[Path], rate: float, show: Callable[[str], None]) -> float | None:
    """Return the worse lip sync of real calls without loss and at 10 %, ms, None if they fail."""
    skews: list[float] = []
    for condition in (CLEAN, LOSS10):
        try:
            with TemporaryDirectory() as folder:
                skew_ms, correlation = measure_skew(
                    clips, Path(folder), kbps=rate, loss=condition.loss.fraction, seconds=SKEW_CALL_S
                )
        except RuntimeError as error:
            show(f"{rate:5g} kbit/s, {condition}: no skew: {error}")
            return None
        skews.append(skew_ms)
        show(f"{rate:5g} kbit/s, {condition}: skew {skew_ms:.0f} ms (r {correlation:.2f})")
    return max(skews, key=abs)


@cache
def read_subject(path: Path) -> tuple[Track | None, Samples]:
    track_path = SHARED / "motion" / f"{path.stem}.npz"
    track = TrackReader().read(track_path, fps=FPS) if track_path.exists() else None
    return track, np.concatenate([samples for _, samples in read_sound(path, rate=SAMPLE_RATE)])


def _table(
    pool: Executor, rate: float, arguments: argparse.Namespace, show: Callable[[str], None]
) -> dict[Condition, Figures]:
    """Show the rows of a rate and return them."""
    level = levels_for(VoiceMode.AUTOMATIC)[highest_level(levels_for(VoiceMode.AUTOMATIC), rate)]
    assert level.voice is not None
    alone = pool.map(partial(_codec_alone, level.voice), arguments.clips)
    show(f"{rate:5g} kbit/s, codec alone: STOI {np.mean(list(alone)):.3f}")
    losses = [Condition(Loss(fraction)) for fraction in arguments.loss]
    rows = {}
    for condition in dict.fromkeys([CLEAN, *losses, BURSTS, *(PLAIN if level.lossy else ())]):
        task = partial(_measure, rate=rate, condition=condition, seconds=arguments.seconds)
        seeds = range(arguments.seed, arguments.seed + len(arguments.clips))
        rows[condition] = found = _joined(list(pool.map(task, arguments.clips, seeds)))
        overall, speech, raw = found.scores
        show(
            f"{rate:5g} kbit/s, {condition!s:23} {found.kbps:6.2f} kbit/s (worst {found.worst_kbps:5.2f}), "
            f"STOI {overall:.3f} ({speech:.3f}, {raw:.3f}), "
            f"face {found.face_error_percent:.2f} % at {found.face_fps:.1f} fps, delay {found.delay_ms:4.0f} ms, "
            f"CPU {found.cpu_ms_per_s:.0f} ms/s"
        )
    return rows


def _measure(path: Path, seed: int, *, rate: float, condition: Condition, seconds: float) -> Measured:
    """Make a call with one clip."""
    track, sound = read_subject(path)
    repeats = not condition.is_plain
    made = call(track, sound, seconds=seconds, kbps=rate, loss=condition.loss, seed=seed, fps=FPS, repeats=repeats)
    scores, delay = compare(sound, made)
    return Measured(replace(made, heard=[], shown=[]), scores, delay)


def _joined(calls: Sequence[Measured]) -> Figures:
    """Return the figures over all clips."""
    errors = np.concatenate([made.errors for made, _, _ in calls])
    intervals = np.concatenate([np.diff(np.sort(made.captured_at)) for made, _, _ in calls])
    return Figures(
        kbps=float(np.mean([made.kbps for made, _, _ in calls])),
        worst_kbps=max(made.worst_kbps for made, _, _ in calls),
        scores=Scores(*np.mean([scores for _, scores, _ in calls], axis=0).tolist()),
        face_error_percent=float(errors.mean()) if len(errors) else float("nan"),
        face_fps=1 / float(np.median(intervals)) if len(intervals) else 0.0,
        delay_ms=1000 * float(np.median([delay - ONE_WAY_S - _datagram_s(made) for made, _, delay in calls])),
        cpu_ms_per_s=1000 * sum(made.cpu_s for made, _, _ in calls) / sum(made.seconds for made, _, _ in calls),
    )


def compare(sound: Samples, made: VoiceCall) -> tuple[Scores, float]:
    """Return STOI after the start, and the delay from microphone to ear, s.

    Each PIECE_S has an alignment of its own, as the playout delay may change in between.
    """
    heard = np.concatenate([np.zeros(int(made.heard_at * SAMPLE_RATE), np.int16), *made.heard])
    captured = sound[np.arange(len(heard)) % len(sound)]
    filtered = high_pass(captured)
    references = filtered, without_pauses(filtered), captured
    size = int(PIECE_S * SAMPLE_RATE)
    scores, lags = [], []
    for begin in range(int(SETTLE_S * SAMPLE_RATE), len(heard) - size - MAX_LAG, size):
        lag = align(filtered[begin : begin + size], heard[begin : begin + size + MAX_LAG], max_samples=MAX_LAG)
        piece = heard[begin + lag : begin + lag + size]
        scores.append([_stoi(reference[begin : begin + size], piece) for reference in references])
        lags.append(lag)
    return Scores(*np.mean(scores, axis=0)), float(np.median(lags)) / SAMPLE_RATE


def _score(captured: Samples, heard: Samples) -> tuple[float, int]:
    """Return the STOI of two sounds of about one length, and by how many samples the second is later."""
    lag = align(captured.astype(float), heard.astype(float), max_samples=MAX_LAG)
    end = min(len(captured), len(heard) - lag)
    return _stoi(captured[:end], heard[lag : lag + end]), lag


def _stoi(captured: Samples, heard: Samples) -> float:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return float(stoi(captured.astype(float), heard.astype(float), SAMPLE_RATE))


def high_pass(sound: Samples) -> Samples:
    """Filter as conf.audio.processing does before anything else."""
    processor = AudioProcessor(SAMPLE_RATE, high_pass_filter=True)
    blocks = sound[: len(sound) // BLOCK_SAMPLES * BLOCK_SAMPLES].reshape(-1, BLOCK_SAMPLES)
    filtered = np.concatenate([processor.process(block) for block in blocks])
    return np.concatenate([filtered, sound[len(filtered) :]])


def without_pauses(sound: Samples) -> Samples:
    """Return the sound with silence where nobody speaks: within 6 dB of the background for a fifth of a second."""
    blocks = sound[: len(sound) // BLOCK_SAMPLES * BLOCK_SAMPLES].reshape(-1, BLOCK_SAMPLES)
    power = np.convolve((blocks.astype(float) ** 2).mean(axis=1), np.ones(5) / 5, mode="same")
    levels = 10 * np.log10(power + 1)
    threshold = min(np.percentile(levels, 5) + ABOVE_BACKGROUND_DB, np.percentile(levels, 95) - BELOW_SPEECH_DB)
    speaks = np.convolve(levels > threshold, np.ones(21), mode="same") > 0
    return np.concatenate([(blocks * speaks[:, None]).ravel().astype(np.int16), sound[blocks.size :]])


def _codec_alone(voice: VoiceFormat, path: Path) -> float:
    """Return the STOI that a codec reaches outside a call."""
    filtered = high_pass(read_subject(path)[1])
    encoder = create_encoder(voice.codec, voice.bit_rate, voice.frame_ms)
    decoder = create_decoder(voice.codec, voice.bit_rate, voice.frame_ms)
    frames = filtered[: len(filtered) // encoder.frame_samples * encoder.frame_samples]
    heard = [decoder.decode(encoder.encode(frame)) for frame in frames.reshape(-1, encoder.frame_samples)]
    return _score(frames, np.concatenate([*heard, np.zeros(MAX_LAG, np.int16)]))[0]


def _datagram_s(made: VoiceCall) -> float:
    """Return the duration that a datagram covers while somebody talks: the median interval between two."""
    times = np.array([at for at, _ in made.sent if at >= SETTLE_S])
    return float(np.median(np.diff(times)))


def _opus_in_rtp(sounds: list[Samples]) -> list[tuple[tuple[float, int], float]]:
    """Return rate, packet duration and STOI of Opus 6000 as other programs send it."""
    results = []
    for frame_ms in (20, 60):
        sizes, scores = [], []
        for sound in sounds:
            encoder, decoder = create_encoder("opus", 6000, frame_ms), create_decoder("opus", 6000, frame_ms)
            count = len(sound) // encoder.frame_samples
            codes = [encoder.encode(frame) for frame in sound[: count * encoder.frame_samples].reshape(count, -1)]
            heard = np.concatenate([decoder.decode(code) for code in codes])
            sizes.append(np.mean([len(code) + HEADER_BYTES + RTP_BYTES for code in codes]))
            scores.append(_score(high_pass(sound)[: len(heard)], heard)[0])
        results.append(((float(np.mean(sizes)) * 8 / frame_ms, frame_ms), float(np.mean(scores))))
    return results


if __name__ == "__main__":
    main()
