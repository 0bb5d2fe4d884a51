"""Draw docs/voice.png: spectrograms of a voice before and after a call. `python tools/docs/voice_figure.py [CLIP]`.

The call is simulated (tools/bench/voice_link.py) at 16 and at 2.4 kbit/s, with a face beside the voice. Under each
spectrogram stand its figures. A click is a difference of neighbouring samples more than 8 times the root mean square of
those within 10 ms of it: in the sound captured none is more than 5 times, in Opus's fricatives 6, in Codec2's pulses
7.7, and of steps as high as the sound's own level half are found. A gap is a pause of 20 ms or more where the captured
sound is loud.
"""

import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, Samples
from tools.bench.voice import CLIPS, FPS, MAX_LAG, compare, high_pass, read_subject
from tools.bench.voice_link import SETTLE_S, Loss, align, call

DOCS = Path(__file__).resolve().parents[2] / "docs"
RATES = (16.0, 2.4)
SHOWN_S, CALL_S = 3.0, 30.0
WINDOW, HOP = 512, 64
SIZE = (1000, 200)  # px of one spectrogram
CAPTION = 36
RANGE_DB = 70.0
CLICK, CLICK_S, SOFT = 8.0, 0.01, 0.1  # SOFT : relative to all differences, added to those around
GAP_S, LOUD, SILENT = 0.02, 0.5, 0.03  # levels are relative to that of the whole sound
INK, PAPER = (40, 40, 40), (255, 255, 255)

Image = NDArray[np.uint8]


def main() -> None:
    """Write the figure and print its path."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clip", nargs="?", type=Path, default=CLIPS[6])
    parser.add_argument("--output", type=Path, default=DOCS / "voice.png")
    options = parser.parse_args()
    track, sound = read_subject(options.clip)
    begin, size = int(SETTLE_S * SAMPLE_RATE), int(SHOWN_S * SAMPLE_RATE)
    captured = high_pass(sound[np.arange(begin + size) % len(sound)])[begin:]
    panels = [panel(captured, f"captured, after the high-pass filter; {SHOWN_S:g} s, 0 to 8 kHz")]
    for rate in RATES:
        made = call(track, sound, seconds=CALL_S, kbps=rate, loss=Loss(), seed=1, fps=FPS)
        (score, _, _), _ = compare(sound, made)
        heard = np.concatenate([np.zeros(round(made.heard_at * SAMPLE_RATE), np.int16), *made.heard])[begin:]
        lag = align(captured.astype(float), heard[: size + MAX_LAG].astype(float), max_samples=MAX_LAG)
        heard = heard[lag : lag + size]
        text = f"{rate:g} kbit/s with the face: sent {made.kbps:.1f}, STOI {score:.2f}, "
        text += f"clicks {clicks(heard)}, gaps {gaps(captured, heard)}"
        panels.append(panel(heard, text))
    cv2.imwrite(str(options.output), np.vstack(panels), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    print(options.output)


def clicks(heard: Samples) -> int:
    """Return how often neighbouring samples differ by much more than those around them do."""
    steps = np.abs(np.diff(heard.astype(float)))
    size = 2 * int(CLICK_S * SAMPLE_RATE) + 1
    around = np.sqrt(np.convolve(steps**2, np.ones(size) / size, mode="same"))
    return int((steps > CLICK * np.hypot(around, SOFT * steps.std())).sum())


def gaps(captured: Samples, heard: Samples) -> int:
    """Return how many stretches of GAP_S are silent though the captured sound is loud."""
    size = int(GAP_S * SAMPLE_RATE)
    count = min(len(captured), len(heard)) // size
    said, played = (sound[: count * size].reshape(count, size).astype(float).std(axis=1) for sound in (captured, heard))
    return int(((said > LOUD * captured.astype(float).std()) & (played < SILENT * heard.astype(float).std())).sum())


def panel(sound: Samples, caption: str) -> Image:
    """Return a spectrogram, dark is loud, low frequencies at the bottom, with a caption under it."""
    starts = np.arange(0, len(sound) - WINDOW, HOP)
    frames = sound[starts[:, None] + np.arange(WINDOW)] * np.hanning(WINDOW)
    levels = 20 * np.log10(np.abs(np.fft.rfft(frames)) + 1.0)
    top = 20 * np.log10(32768 * WINDOW / 16)
    grey = 255 * np.clip((top - levels.T[::-1]) / RANGE_DB, 0, 1)
    image = cv2.cvtColor(cv2.resize(grey.astype(np.uint8), SIZE, interpolation=cv2.INTER_AREA), cv2.COLOR_GRAY2BGR)
    strip = np.full((CAPTION, SIZE[0], 3), PAPER, np.uint8)
    cv2.putText(strip, caption, (8, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, INK, 1, cv2.LINE_AA)
    return np.vstack([image, strip]).astype(np.uint8)


if __name__ == "__main__":
    main()
