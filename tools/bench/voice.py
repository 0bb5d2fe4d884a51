"""Measure voice and face together at each link rate: rate, intelligibility, error of the face, delay, CPU time.

    python tools/bench/voice.py [CLIP...] [--rates 16 9.6 6 4.8 2.4] [--loss 0 0.05 0.1 0.2] [--seconds 30]
        [--skew] [--devices]
    python tools/bench/voice.py --json [CLIP...] [--rates ...] [--seconds 30]

Without clips, the talking clips of ../shared/media whose tracks are in ../shared/motion. Calls are simulated
(voice_link.py): everything but the network and the clock is the program's. Beside the rates: Opus 6000 in RTP, voice
alone.

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

--json does all of it and prints an object by rate, half an hour later for all rates and clips:

kbps, face_error_percent, cpu_ms_per_s : without loss
stoi, stoi_loss10 : without loss and at 10 %
skew_ms : without loss or at 10 %, whichever is further from 0; plus is sound that is early; null without GRID clips
delay_ms : from microphone to loudspeaker, less the datagram's own duration, through PulseAudio's null sink; without
    PulseAudio as in the table: without devices
"""

import argparse
import json
import os
import shutil
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
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
LOSS10, BURST = Loss(0.1), Loss(0.1, 3)
FPS = 30.0
RTP_BYTES = 12
SKEW_CALL_S = 10.0  # of each real call: three times a GRID clip
PIECE_S = 3.0  # of sound with one alignment
ABOVE_BACKGROUND_DB, BELOW_SPEECH_DB = 6.0, 20.0
MAX_LAG = int(1.5 * SAMPLE_RATE)


@dataclass(frozen=True)
class Figures:
    """Of one rate and loss, over all clips.

    face_fps : while the face moves: from the median interval of the received frames. One that does not move is not sent
    stoi, speech_stoi, raw_stoi : see Scores
    delay_ms : from microphone to ear, less the network and the datagram
    """

    kbps: float
    worst_kbps: float
    stoi: float
    speech_stoi: float
    raw_stoi: float
    face_error_percent: float
    face_fps: float
    delay_ms: float
    cpu_ms_per_s: float


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clips", nargs="*", type=Path, default=CLIPS, metavar="CLIP")
    parser.add_argument("--rates", nargs="+", type=float, default=RATES, metavar="KBPS")
    parser.add_argument("--loss", nargs="+", type=float, default=LOSSES, metavar="FRACTION", help="of the table")
    parser.add_argument("--seconds", type=float, default=30.0, help="duration of each call; clips are repeated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--skew", action="store_true", help="measure the lip sync of real calls")
    parser.add_argument("--devices", action="store_true", help="measure the delay through a sound server")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    subjects = [read_subject(path) for path in arguments.clips]
    if arguments.json:
        print(json.dumps(_summaries(subjects, arguments), indent=2))
        return
    losses = [Loss(fraction) for fraction in arguments.loss] + [BURST]
    for rate in arguments.rates:
        print(f"{rate:5g} kbit/s, codec alone: STOI {_codec_alone(rate, subjects):.3f}")
        for loss in losses:
            _print(rate, loss, _measure(subjects, rate, loss, arguments))
    for packet, score in _opus_in_rtp([sound for _, sound in subjects]):
        print(f"Opus 6000 in RTP, {packet[1]} ms, no face: {packet[0]:.1f} kbit/s, STOI {score:.3f}")
    if arguments.devices:
        for rate, delay_ms in measure_delays(arguments.rates).items():
            print(f"{rate:5g} kbit/s through a sound server: delay {delay_ms:.0f} ms", flush=True)
    for rate in arguments.rates if arguments.skew else ():
        for loss in (Loss(), LOSS10):
            skew_ms, correlation = _skew(arguments.clips, rate, loss)
            print(
                f"{rate:5g} kbit/s, loss {loss.fraction:.0%}: skew {skew_ms:.0f} ms (r {correlation:.2f})", flush=True
            )


def _summaries(
    subjects: list[tuple[Track | None, Samples]], arguments: argparse.Namespace
) -> dict[str, dict[str, float | None]]:
    """Return what --json prints, and report the progress on the error output."""
    has_grid = any(map(_is_grid, arguments.clips))
    delays = measure_delays(arguments.rates) if shutil.which("pulseaudio") else {}
    summaries = {}
    for rate in arguments.rates:
        print(f"{rate:g} kbit/s", file=sys.stderr, flush=True)
        clean, lossy = (_measure(subjects, rate, loss, arguments) for loss in (Loss(), LOSS10))
        skews = [_skew(arguments.clips, rate, loss)[0] for loss in (Loss(), LOSS10)] if has_grid else []
        summaries[f"{rate:g}"] = summary(clean, lossy, skews, delays.get(rate))
    return summaries


def summary(
    clean: Figures, lossy: Figures, skews_ms: Sequence[float], delay_ms: float | None
) -> dict[str, float | None]:
    """Return one rate's object of --json; delay_ms : None to use the one without devices"""
    return {
        "kbps": clean.kbps,
        "stoi": clean.stoi,
        "stoi_loss10": lossy.stoi,
        "face_error_percent": clean.face_error_percent,
        "skew_ms": max(skews_ms, key=abs, default=None),
        "delay_ms": clean.delay_ms if delay_ms is None else delay_ms,
        "cpu_ms_per_s": clean.cpu_ms_per_s,
    }


def _is_grid(path: Path) -> bool:
    return path.stem.startswith("grid_")


def _skew(clips: list[Path], rate: float, loss: Loss) -> tuple[float, float]:
    """Return the lip sync of real calls, pooled over the GRID clips, ms, and the correlation."""
    with TemporaryDirectory() as folder:
        grid = list(filter(_is_grid, clips))
        return measure_skew(grid, Path(folder), kbps=rate, loss=loss.fraction, seconds=SKEW_CALL_S)


def read_subject(path: Path) -> tuple[Track | None, Samples]:
    track_path = SHARED / "motion" / f"{path.stem}.npz"
    track = TrackReader().read(track_path, fps=FPS) if track_path.exists() else None
    return track, np.concatenate([samples for _, samples in read_sound(path, rate=SAMPLE_RATE)])


def _measure(
    subjects: list[tuple[Track | None, Samples]], rate: float, loss: Loss, arguments: argparse.Namespace
) -> Figures:
    calls, scores, delays, packets = [], [], [], []
    for index, (track, sound) in enumerate(subjects):
        made = call(track, sound, seconds=arguments.seconds, kbps=rate, loss=loss, seed=arguments.seed + index, fps=FPS)
        score, delay = compare(sound, made)
        calls.append(made)
        scores.append(score)
        delays.append(delay)
        packets.append(_datagram_s(made))
    errors = np.concatenate([made.errors for made in calls])
    intervals = np.concatenate([np.diff(np.sort(made.captured_at)) for made in calls])
    return Figures(
        kbps=float(np.mean([made.kbps for made in calls])),
        worst_kbps=max(made.worst_kbps for made in calls),
        stoi=float(np.mean([score.filtered for score in scores])),
        speech_stoi=float(np.mean([score.speech for score in scores])),
        raw_stoi=float(np.mean([score.raw for score in scores])),
        face_error_percent=float(errors.mean()) if len(errors) else float("nan"),
        face_fps=1 / float(np.median(intervals)) if len(intervals) else 0.0,
        delay_ms=1000 * float(np.median(np.array(delays) - ONE_WAY_S - np.array(packets))),
        cpu_ms_per_s=1000 * sum(made.cpu_s for made in calls) / sum(made.seconds for made in calls),
    )


class Scores(NamedTuple):
    """STOI against the filtered sound, against the same without its pauses, and against the raw sound."""

    filtered: float
    speech: float
    raw: float


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


def _codec_alone(rate: float, subjects: list[tuple[Track | None, Samples]]) -> float:
    """Return the STOI that the codec of a rate's level reaches outside a call."""
    levels = levels_for(VoiceMode.AUTOMATIC)
    voice = levels[highest_level(levels, rate)].voice
    assert voice is not None
    scores = []
    for _, sound in subjects:
        filtered = high_pass(sound)
        encoder = create_encoder(voice.codec, voice.bit_rate, voice.frame_ms)
        decoder = create_decoder(voice.codec, voice.bit_rate, voice.frame_ms)
        frames = filtered[: len(filtered) // encoder.frame_samples * encoder.frame_samples]
        heard = [decoder.decode(encoder.encode(frame)) for frame in frames.reshape(-1, encoder.frame_samples)]
        scores.append(_score(frames, np.concatenate([*heard, np.zeros(MAX_LAG, np.int16)]))[0])
    return float(np.mean(scores))


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


def _print(rate: float, loss: Loss, found: Figures) -> None:
    lost = f"{loss.fraction:.0%}" + (f" in bursts of {loss.burst}" if loss.burst > 1 else "")
    print(
        f"{rate:5g} kbit/s, loss {lost:18} {found.kbps:6.2f} kbit/s (worst {found.worst_kbps:5.2f}), "
        f"STOI {found.stoi:.3f} ({found.speech_stoi:.3f}, {found.raw_stoi:.3f}), "
        f"face {found.face_error_percent:.2f} % at {found.face_fps:.1f} fps, delay {found.delay_ms:4.0f} ms, "
        f"CPU {found.cpu_ms_per_s:.0f} ms/s",
        flush=True,
    )


if __name__ == "__main__":
    main()
