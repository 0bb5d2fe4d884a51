"""Measure the delay of the voice from the microphone to the loudspeaker, through the sound system of this machine.

    python tools/bench/voice_devices.py [--clips CLIP...] [--rates 16 9.6 6 4.8 2.4] [--seconds 25] [--json]

Needs PulseAudio's programs, no sound card: a server of its own has two null sinks. Speech is played into the first,
whose monitor is the microphone of a sender; a receiver plays to the second. Sender and receiver are two processes on
loopback, with the loops of `conf send` and `conf receive` (call_probe.py). The monitors of both sinks are recorded, and
the delay is the lag at which the recordings correlate best, a figure for each PIECE_S.

delay_ms : the median, less the duration of the voice in a datagram, which nobody can avoid; least_ms, worst_ms : of
single pieces: whatever stops the processes for a moment adds to the playout delay for ten seconds and more; error_ms :
between two recordings of the same sink, which is how exact the figures are; gaps : silences of MIN_GAP_S and more that
interrupt the sound, which the sound server plays when it has been given too little
"""

import argparse
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.audio.samples import SAMPLE_RATE, Samples
from conf.commands.extract import extract
from conf.protocol.rate_control.rate_levels import VoiceMode, levels_for
from conf.sender.capture.clip import read_sound
from tools.bench.call_probe import read_lines, start, start_receiver
from tools.bench.voice_link import align

SHARED = Path(__file__).resolve().parents[3] / "shared"
GRID = ("bbaf2n", "brbk7n", "lbax4n", "lbbc2a", "lwbsza", "pwij3p", "swiz3n")
CLIPS = [SHARED / "media" / f"grid_{name}.mpg" for name in GRID]
RATES = (16.0, 9.6, 6.0, 4.8, 2.4)
CODE = "amber-canoe-tiger-7"
SECONDS = 25.0  # of each call
STARTING_S = 90.0  # maximum time for the processes to start: 4 s on a quiet machine
ATTEMPTS = 2  # at a call; a machine that is too busy fails
SINK_STARTS_S = 3.0  # a null sink that nobody listens to is up to 2 s ahead of the clock
SETTLE_S = 14.0  # of the recordings before pieces count: the call begins, the playout delay finds its length
PIECE_S = 3.0
MAX_LAG = int(1.5 * SAMPLE_RATE)
MIN_LEVEL = 100.0  # RMS of a piece with speech
MIN_GAP_S, BESIDE_S = 0.001, 0.005  # of a gap, and of the sound beside it
RECORD_FORMAT = ["--format=s16le", "--channels=1", f"--rate={SAMPLE_RATE}"]
RECORD_LATENCY_MS = 20
CHUNK_BYTES = 640  # 20 ms
MICROPHONE, LOUDSPEAKER = "bench_microphone", "bench_loudspeaker"


@dataclass(frozen=True)
class Figures:
    """Of a call at one rate; see above. underruns : how often the loudspeaker had nothing to play"""

    delay_ms: float
    least_ms: float
    worst_ms: float
    datagram_ms: int
    pieces: int
    underruns: int
    gaps: int
    error_ms: float


class Recording:
    """What a sink plays, and when.

    The median arrival of the second half of its samples tells when the recording began: at first a null sink may be
    seconds ahead of the clock.
    """

    def __init__(self, sink: str) -> None:
        command = ["parec", f"--device={sink}.monitor", *RECORD_FORMAT, f"--latency-msec={RECORD_LATENCY_MS}"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE)
        self._chunks: list[bytes] = []
        self._begins: list[float] = []  # by each chunk's arrival
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def stop(self) -> Samples:
        """Return the samples, (n,) at SAMPLE_RATE; the first was played at `began`."""
        self._process.terminate()
        self._thread.join()
        self._process.communicate()
        data = b"".join(self._chunks)
        return np.frombuffer(data[: len(data) // 2 * 2], np.int16)

    @property
    def began(self) -> float:
        """When the first sample was played, but for the time that all samples take to arrive, s."""
        return float(np.median(self._begins[len(self._begins) // 2 :]))

    def _read(self) -> None:
        assert self._process.stdout
        size = 0
        while chunk := self._process.stdout.read(CHUNK_BYTES):
            self._chunks.append(chunk)
            size += len(chunk)
            self._begins.append(time.monotonic() - size / 2 / SAMPLE_RATE)


@contextmanager
def sound_server() -> Iterator[None]:
    """Run a sound server with two null sinks, which the programs started meanwhile use."""
    with TemporaryDirectory() as folder:
        socket = Path(folder, "native")
        environment = os.environ | {"XDG_RUNTIME_DIR": folder, "PULSE_RUNTIME_PATH": folder, "HOME": folder}
        modules = [f"module-native-protocol-unix socket={socket} auth-anonymous=1"]
        modules += [f"module-null-sink sink_name={sink} rate=48000" for sink in (MICROPHONE, LOUDSPEAKER)]
        command = ["pulseaudio", "-n", "--exit-idle-time=-1", "--daemonize=no", "--log-level=error"]
        command += [argument for module in modules for argument in ("-L", module)]
        before = {name: os.environ.get(name) for name in ("PULSE_SERVER", "PULSE_SINK", "PULSE_SOURCE")}
        with subprocess.Popen(command, env=environment) as server:
            os.environ |= {"PULSE_SERVER": f"unix:{socket}", "PULSE_SINK": LOUDSPEAKER}
            os.environ["PULSE_SOURCE"] = f"{MICROPHONE}.monitor"
            try:
                _wait_for(socket)
                yield
            finally:
                server.terminate()
                for name, value in before.items():
                    os.environ.pop(name)
                    if value is not None:
                        os.environ[name] = value


def _wait_for(path: Path) -> None:
    deadline = time.monotonic() + STARTING_S
    while not path.exists():
        if time.monotonic() > deadline:
            raise RuntimeError("the sound server does not start")
        time.sleep(0.05)


def measure(motion: Path, speech: Path, kbps: float, seconds: float) -> Figures:
    """Make a call and measure it.

    speech : raw samples at SAMPLE_RATE, at least as long as the call
    Raises RuntimeError, ValueError or subprocess.TimeoutExpired if the machine is too busy for it.
    """
    recordings = captured, again, heard = Recording(MICROPHONE), Recording(MICROPHONE), Recording(LOUDSPEAKER)
    processes: list[subprocess.Popen[str]] = []
    lines: list[dict[str, float]] = []
    try:
        time.sleep(SINK_STARTS_S)
        receiver, address = start_receiver(CODE, seconds + STARTING_S, "--speaker", "", "--fps", 15)
        processes.append(receiver)
        reader = threading.Thread(target=read_lines, args=(receiver.stdout, lines))
        reader.start()
        processes.append(subprocess.Popen(["pacat", f"--device={MICROPHONE}", *RECORD_FORMAT, str(speech)], text=True))
        processes.append(start("send", address, CODE, seconds, motion, "--microphone", "0", "--kbps", kbps))
        processes[-1].communicate(timeout=seconds + STARTING_S)
    finally:
        for process in processes:
            process.kill()
            process.wait()
        sounds = [recording.stop() for recording in recordings]
    reader.join()
    delays = lags(sounds[0], sounds[2], heard.began - captured.began)
    errors = lags(sounds[0], sounds[1], again.began - captured.began)
    if not delays:
        raise RuntimeError("no speech was heard: does `conf doctor` find the sound devices?")
    datagram_ms = next(
        level.voice.packet_ms for level in levels_for(VoiceMode.AUTOMATIC) if level.voice and level.kbps == kbps
    )
    return Figures(
        delay_ms=round(1000 * float(np.median(delays)) - datagram_ms, 1),
        least_ms=round(1000 * min(delays) - datagram_ms, 1),
        worst_ms=round(1000 * max(delays) - datagram_ms, 1),
        datagram_ms=datagram_ms,
        pieces=len(delays),
        underruns=int(max(line.get("underruns", 0) for line in lines)),
        gaps=count_gaps(sounds[2][int(SETTLE_S * SAMPLE_RATE) :]),
        error_ms=round(1000 * max(map(abs, errors)), 1),
    )


def measure_all(
    clips: Sequence[Path], rates: Sequence[float], seconds: float
) -> Iterator[tuple[float, Figures | None]]:
    """Make a call at each rate and measure it, with the motion of the first clip and the sound of all.

    Yields None for a rate at which ATTEMPTS calls have failed, and prints why.
    """
    sounds = [samples for clip in clips for _, samples in read_sound(clip, rate=SAMPLE_RATE)]
    speech = np.resize(np.concatenate(sounds), int((seconds + STARTING_S) * SAMPLE_RATE))
    with TemporaryDirectory() as folder, sound_server():
        motion, raw = Path(folder, "motion.dpc"), Path(folder, "speech.raw")
        extract(clips[0], motion)
        raw.write_bytes(speech.tobytes())
        for kbps in rates:
            yield kbps, _measure_again(motion, raw, kbps, seconds)


def _measure_again(motion: Path, speech: Path, kbps: float, seconds: float) -> Figures | None:
    for _ in range(ATTEMPTS):
        try:
            return measure(motion, speech, kbps, seconds)
        except (RuntimeError, ValueError, subprocess.TimeoutExpired) as error:
            print(f"{kbps:g} kbit/s: the call failed: {error}", file=sys.stderr, flush=True)
    return None


def measure_delays(rates: Sequence[float]) -> dict[float, float | None]:
    """Return the delay at each rate, ms, with the GRID clips, None where calls fail."""
    return {kbps: figures.delay_ms if figures else None for kbps, figures in measure_all(CLIPS, rates, SECONDS)}


def lags(captured: Samples, heard: Samples, offset_s: float) -> list[float]:
    """Return by how many seconds each piece of `captured` is heard later.

    offset_s : by how much later the recording of what is heard began
    """
    early = MAX_LAG // 2 + round(offset_s * SAMPLE_RATE)
    shifted = np.concatenate([np.zeros(max(early, 0), np.int16), heard[max(-early, 0) :]])
    size, found = int(PIECE_S * SAMPLE_RATE), []
    for begin in range(int(SETTLE_S * SAMPLE_RATE), min(len(captured), len(shifted) - MAX_LAG) - size, size):
        piece, later = (
            captured[begin : begin + size].astype(float),
            shifted[begin : begin + size + MAX_LAG].astype(float),
        )
        if min(np.std(piece), np.std(later[:size])) > MIN_LEVEL:
            found.append((align(piece, later, max_samples=MAX_LAG) - MAX_LAG // 2) / SAMPLE_RATE)
    return found


def count_gaps(sound: Samples) -> int:
    """Return how often a sound is interrupted by silence: not where speech ends softly, nor at the end."""
    silent = np.concatenate([[False], np.abs(sound.astype(int)) <= 1, [False]])
    edges = np.flatnonzero(np.diff(silent.astype(int)))
    beside = int(BESIDE_S * SAMPLE_RATE)
    count = 0
    for begin, end in edges.reshape(-1, 2):
        if end - begin >= MIN_GAP_S * SAMPLE_RATE and end < len(sound):  # at the end the receiver is stopped
            neighbours = sound[max(begin - beside, 0) : begin], sound[end : end + beside]
            count += any(len(part) and np.std(part.astype(float)) > MIN_LEVEL for part in neighbours)
    return count


def main() -> None:
    """Print a row for each rate, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clips", nargs="+", type=Path, default=CLIPS, metavar="CLIP")
    parser.add_argument("--rates", nargs="+", type=float, default=RATES, metavar="KBPS")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="duration of each call")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    result = {}
    for kbps, figures in measure_all(options.clips, options.rates, options.seconds):
        result[f"{kbps:g}"] = values = asdict(figures) if figures else None
        if values and not options.json:
            print(f"{kbps:5g} kbit/s:", ", ".join(f"{name} {value}" for name, value in values.items()), flush=True)
    if options.json:
        print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
