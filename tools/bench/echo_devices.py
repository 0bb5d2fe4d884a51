"""Measure echo cancellation through the sound system of this machine: a loudspeaker, a simulated room, a microphone.

    python tools/bench/echo_devices.py [--room office] [--seconds 30] [--save FILE.npz] [--json]
    python tools/bench/echo_devices.py --replay FILE.npz [--json]

Needs PulseAudio's programs, no sound card: a server of its own has a null sink for the loudspeaker and a pipe for the
microphone. A process reads what the sink plays, convolves it with the response of the room and writes it, with the
room's noise, into the pipe: it keeps the loudspeaker's clock, as no resampler of the sound server is between.
Devices and echo canceller are those of a call. The speech is that of echo.py. What the devices gave can be kept, and
measured again without them, with another version of the canceller.

erle_db : echo return loss enhancement in each second in which there was an echo, from the first one on; erle_3s : the
median from 3 s on; quiet : in how many of those seconds the echo was 30 dB quieter, and how many there were;
missing_s : for how long the sound server got nothing to play after the first 3 s, as the machine was busy: figures with
more than a few hundredths tell of the machine
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.audio.devices import Microphone, Speaker, open_microphone, open_speaker
from conf.audio.echo_canceller import EchoCanceller
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, to_int16
from tools.bench.device_tape import DeviceTape
from tools.bench.echo import BLOCK, FAR, FAR_DBFS, read_speech
from tools.bench.rooms import ROOMS, room_noise, room_response
from tools.bench.voice_devices import LOUDSPEAKER, RECORD_FORMAT, SINK_STARTS_S, sound_server

ECHO_GAIN = 0.5
QUEUED_S = 0.06  # written ahead to the loudspeaker
MIN_ECHO = 30.0  # RMS of a second with an echo
MIN_ERLE = 30.0  # dB
SETTLED_S = 3.0
POLL_S = 0.005
PIPE_SOURCE = "bench_room"


def carry(room: str, pipe: Path) -> None:
    """Carry sound from the loudspeaker to the microphone until the sound server ends."""
    response = room_response(ROOMS[room]) * ECHO_GAIN
    tail, noise, position = np.zeros(len(response) - 1), room_noise(SAMPLE_RATE), 0
    command = ["parec", f"--device={LOUDSPEAKER}.monitor", *RECORD_FORMAT, "--latency-msec=20"]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as recorder,
        pipe.open("wb", buffering=0) as microphone,
    ):
        assert recorder.stdout
        print("running", flush=True)
        while len(data := recorder.stdout.read(2 * BLOCK)) == 2 * BLOCK:
            sound = np.convolve(np.frombuffer(data, np.int16).astype(float), response)
            sound[: len(tail)] += tail
            tail = sound[BLOCK:].copy()
            microphone.write(to_int16(sound[:BLOCK] + noise[position : position + BLOCK]).tobytes())
            position = (position + BLOCK) % (SAMPLE_RATE - BLOCK)


def record(room: str, seconds: float) -> DeviceTape:
    """Play speech for so long in a room and return what the devices gave."""
    speech = to_int16(read_speech(FAR, FAR_DBFS))
    with sound_server():
        pipe = Path(os.environ["PULSE_SERVER"].removeprefix("unix:")).parent / "room"
        options = [f"source_name={PIPE_SOURCE}", f"file={pipe}", "format=s16le", f"rate={SAMPLE_RATE}", "channels=1"]
        subprocess.run(["pactl", "load-module", "module-pipe-source", *options], check=True, stdout=subprocess.DEVNULL)
        os.environ["PULSE_SOURCE"] = PIPE_SOURCE
        command = [sys.executable, __file__, "--room", room, "--pipe", str(pipe)]
        carrier = subprocess.Popen(command, stdout=subprocess.PIPE)
        try:
            assert carrier.stdout
            carrier.stdout.readline()  # it runs
            time.sleep(SINK_STARTS_S)
            with open_microphone() as microphone, open_speaker() as speaker:
                return _listen(
                    microphone, speaker, np.tile(speech, 1 + int(seconds * SAMPLE_RATE) // len(speech)), seconds
                )
        finally:
            carrier.kill()
            carrier.wait()


def _listen(microphone: Microphone, speaker: Speaker, speech: Samples, seconds: float) -> DeviceTape:
    """Play speech for so long and return what the devices gave."""
    tape, written = DeviceTape(), 0
    tape.attach(microphone, speaker)
    began = time.monotonic()
    while (now := time.monotonic()) < began + seconds:
        while speaker.queued_s < QUEUED_S:
            speaker.write(speech[written : written + BLOCK])
            written += BLOCK
        tape.reads.append(now)
        speaker.read_played()
        microphone.read()
        time.sleep(POLL_S)
    return tape


def evaluate(tape: DeviceTape) -> dict[str, Any]:
    """Return the figures of what the devices gave."""
    canceller = EchoCanceller()
    before: list[AudioBlock] = []
    after: list[AudioBlock] = []
    missing, end = 0.0, None
    for recorded, played in tape.replay():
        if played is not None:
            if end is not None and played.timestamp > tape.reads[0] + SETTLED_S:
                missing += max(played.timestamp - end, 0.0)
            end = played.end
        if recorded is not None:
            before.append(recorded)
            after.append(canceller.process(recorded, played))
        elif played is not None:
            canceller._played.append(played)
    origin = before[0].timestamp
    raw, rest = (_track(blocks, origin) for blocks in (before, after))
    figures = erle_by_second(raw, rest)
    steady = [value for value in figures[3:] if value is not None]
    return {
        "erle_3s": round(float(np.median(steady)), 1) if steady else None,
        "erle_db": figures,
        "quiet": [sum(value >= MIN_ERLE for value in steady), len(steady)],
        "delay_ms": None if canceller.delay_s is None else round(1000 * canceller.delay_s, 1),
        "missing_s": round(missing, 3),
    }


def _track(blocks: list[AudioBlock], origin: float) -> Samples:
    """Return blocks in one track from a time on."""
    track = np.zeros(round((blocks[-1].end - origin + 1.0) * SAMPLE_RATE), np.int16)
    for block in blocks:
        first = round((block.timestamp - origin) * SAMPLE_RATE)
        if first >= 0:
            track[first : first + len(block.samples)] = block.samples
    return track


def erle_by_second(before: Samples, after: Samples) -> list[float | None]:
    """Return how much quieter each second with an echo is after cancellation, dB, None for those without."""
    figures: list[float | None] = []
    for first in range(0, min(len(before), len(after)) - SAMPLE_RATE, SAMPLE_RATE):
        levels = [float(np.std(sound[first : first + SAMPLE_RATE].astype(float))) for sound in (before, after)]
        heard = levels[0] > MIN_ECHO
        if heard or figures:
            figures.append(round(20 * float(np.log10(levels[0] / max(levels[1], 0.1))), 1) if heard else None)
    return figures


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--room", choices=[*ROOMS], default="office")
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--save", type=Path, metavar="FILE.npz", help="keep what the devices gave")
    parser.add_argument("--replay", type=Path, metavar="FILE.npz", help="measure what --save kept, without devices")
    parser.add_argument("--pipe", type=Path, help=argparse.SUPPRESS)  # the room, in a process of its own
    options = parser.parse_args()
    if options.pipe:
        carry(options.room, options.pipe)
        return
    tape = DeviceTape.load(options.replay) if options.replay else record(options.room, options.seconds)
    if options.save:
        tape.save(options.save)
    result = evaluate(tape)
    print(json.dumps(result) if options.json else "\n".join(f"{name:10} {value}" for name, value in result.items()))


if __name__ == "__main__":
    main()
