"""Measure voice codecs and processing: CPU, bit rate, intelligibility with and without loss, a row for each format.

    python tools/bench/voice_codecs.py [CLIP ...] [--loss 0 0.1 0.2] [--seed 1] [--json]

CLIPs are files with speech, by default the GRID clips in the folder `shared/media` beside the repository. Each clip is
processed (high-pass filter, noise suppression, gain, activity), encoded, and decoded with independent random loss of
frames. `stoi` (pystoi) compares the decoded sound with the processed one, `stoi_in` the processed with the high-passed
clip; both are means over clips. The reference is high-passed because GRID has rumble below 80 Hz that no step is meant
to keep. CPU is processor time in ms for one second of sound: median over clips of processing, and of encoding plus
decoding; `cpu` is their sum. The target is 40 ms.
"""

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from pystoi import stoi
from pywebrtc_audio import AudioProcessor

from conf.audio.codecs.registry import create_decoder, create_encoder
from conf.audio.processing import BLOCK_SAMPLES, VoiceProcessor
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.sender.capture.clip import read_sound

CLIPS = Path(__file__).resolve().parents[3] / "shared" / "media"
FORMATS = [
    *(("opus", rate, 60) for rate in (6000, 9000, 12000)),
    *(("codec2", rate, 20) for rate in (3200, 2400)),
    *(("codec2", rate, 40) for rate in (1600, 1200, 700)),
]


@dataclass(frozen=True)
class Clip:
    """A clip's sound after processing. cpu : of processing, ms a second; stoi : against the high-passed clip"""

    sound: Samples
    cpu: float
    stoi: float
    active: float


@dataclass(frozen=True)
class Row:
    """Figures of one format at one rate of loss."""

    codec: str
    bit_rate: int
    frame_ms: int
    loss: float
    kbps: float
    stoi: float
    coding_cpu: float
    cpu: float


def process(path: Path) -> Clip:
    """Read and process a clip."""
    sound = np.concatenate([samples for _, samples in read_sound(path, rate=SAMPLE_RATE)])
    sound = sound[: len(sound) // BLOCK_SAMPLES * BLOCK_SAMPLES]
    high_pass = AudioProcessor(SAMPLE_RATE, high_pass_filter=True)
    reference = np.concatenate([high_pass.process(block) for block in sound.reshape(-1, BLOCK_SAMPLES)])
    processor, blocks = VoiceProcessor(), []
    start = time.process_time()
    for first in range(0, len(sound), 2 * BLOCK_SAMPLES):
        piece = sound[first : first + 2 * BLOCK_SAMPLES]
        blocks += processor.process(AudioBlock(first / SAMPLE_RATE, piece))
    cpu = 1e3 * (time.process_time() - start) / (len(sound) / SAMPLE_RATE)
    processed = np.concatenate([block.samples for block in blocks])
    value = compare(reference, processed, -blocks[0].timestamp)
    return Clip(processed, cpu, value, statistics.fmean(block.active for block in blocks))


def compare(reference: Samples, sound: Samples, delay_s: float) -> float:
    """Return STOI of a sound that lags."""
    lag = round(delay_s * SAMPLE_RATE)
    count = min(len(reference), len(sound) - lag)
    return float(stoi(reference[:count], sound[lag : lag + count], SAMPLE_RATE))


def measure(clips: list[Clip], form: tuple[str, int, int], loss: float, seed: int) -> Row:
    """Return the figures of one format."""
    rng = np.random.default_rng(seed)
    values, cpus, size, seconds = [], [], 0, 0.0
    for clip in clips:
        encoder, decoder = create_encoder(*form), create_decoder(*form)
        usable = clip.sound[: len(clip.sound) // encoder.frame_samples * encoder.frame_samples]
        lost = rng.random(len(usable) // encoder.frame_samples) < loss
        start = time.process_time()
        frames = [encoder.encode(frame) for frame in usable.reshape(-1, encoder.frame_samples)]
        parts = [decoder.conceal() if gone else decoder.decode(data) for data, gone in zip(frames, lost, strict=True)]
        duration = len(usable) / SAMPLE_RATE
        cpus.append(1e3 * (time.process_time() - start) / duration)
        values.append(compare(usable, np.concatenate(parts), decoder.delay_s))
        size, seconds = size + sum(map(len, frames)), seconds + duration
    coding = statistics.median(cpus)
    total = coding + statistics.median(clip.cpu for clip in clips)
    return Row(*form, loss, 8e-3 * size / seconds, statistics.fmean(values), coding, total)


def table(clips: list[Clip], rows: list[Row]) -> Iterator[str]:
    """Yield the lines for a reader."""
    cpu = statistics.median(clip.cpu for clip in clips)
    value = statistics.fmean(clip.stoi for clip in clips)
    yield f"processing: {cpu:.1f} ms/s, STOI {value:.3f}, active {statistics.fmean(c.active for c in clips):.2f}"
    for row in rows:
        name = f"{row.codec} {row.bit_rate} / {row.frame_ms} ms"
        yield f"{name:20} loss {row.loss:4.0%}  {row.kbps:5.2f} kbit/s  STOI {row.stoi:.3f}  CPU {row.cpu:5.1f} ms/s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", nargs="*", type=Path)
    parser.add_argument("--loss", nargs="+", type=float, default=[0.0, 0.1, 0.2])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    clips = [process(path) for path in options.clips or sorted(CLIPS.glob("grid_*.mpg"))]
    if not clips:
        parser.error(f"there are no GRID clips in {CLIPS}: name clips")
    rows = [measure(clips, form, loss, options.seed) for form in FORMATS for loss in options.loss]
    if options.json:
        processing = [{"cpu": clip.cpu, "stoi_in": clip.stoi, "active": clip.active} for clip in clips]
        print(json.dumps({"clips": processing, "rows": [asdict(row) for row in rows]}))
        return
    print("\n".join(table(clips, rows)))


if __name__ == "__main__":
    main()
