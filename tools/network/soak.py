"""Make a long call over a lossy link, a looped clip through tools/network/impair.py, and print figures over time.

    python tools/network/soak.py [--minutes 60] [--loss 0.05] [--clip CLIP] [--sound [SPEAKER]] [--call] [--json]

Sender and receiver are two processes (tools/bench/call_probe.py). Each row is a tenth of the call: memory of both ends,
frames received, lost and late, playout delay, the median time from a frame's capture to the image that shows it, the
longest time between two captures, and the longest stall, which is the time of the playhead past a frame that was sent
and has not arrived; a face that holds still is not sent and does not stall. No column may grow with the length of the
call. A stall next to a capture gap of the same length was caused by other load on the machine, which stopped both.

machine_gap_s is the longest time by which a thread that sleeps for SLEEP_S woke up too late: a machine that stops
everybody, which no program can mend.

--sound plays the voice of a clip with sound on a loudspeaker (`conf devices`; "null" needs none) and adds a row each
minute: underruns, concealed sound, and by how much sound is ahead of the lips (sound_soak.py). Motion and sound are
extracted once, as tracking would load the machine, and the receiver draws SOUND_FPS frames a second.

--call makes a call of two instead, with the voice of both: two processes as of `conf call`
(tools/bench/call_end_probe.py), each of which sends the clip and draws the other. The rows of each direction are those
of --sound; `sender_kb` of one direction is `receiver_kb` of the other.

    python tools/network/soak.py --call --minutes 60 --loss 0.05 --clip CLIP --sound null --json
"""

import argparse
import json
import math
import subprocess
import sys
import threading
import time
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.commands.extract import extract
from tools.bench import call_end_probe
from tools.bench.call_probe import read_lines, split_address, start, start_receiver
from tools.bench.carphone import fetch_carphone
from tools.network.impair import Faults, Relay
from tools.network.sound_soak import sound_row, sound_totals

CODE = "amber-canoe-tiger-7"
ROWS = 10
STARTING_S = 60.0  # maximum time for the processes to start on a busy machine
SLEEP_S = 0.01
SOUND_FPS = 15
HALF_FRAME_S = 1 / 60  # stream times of frames are rounded to their numbers
START_S = 3.0  # excluded from growth: handshake, calibration, memory that is allocated once
Lines = list[dict[str, Any]]


def call(
    clip: Path,
    seconds: float,
    faults: Faults,
    *,
    seed: int = 1,
    sender_options: Sequence[object] = (),
    receiver_options: Sequence[object] = (),
) -> tuple[Lines, Lines]:
    """Make a call through a relay; return the log lines of sender and receiver.

    sender_options, receiver_options : further arguments of call_probe.py
    """
    receiver, address = start_receiver(CODE, seconds + STARTING_S, *receiver_options)
    relay = Relay(("127.0.0.1", 0), split_address(address), faults, seed=seed)
    sender = start("send", "{}:{}".format(*relay.address), CODE, seconds, clip, *sender_options)
    return _logs(sender, receiver, relay, seconds)


def call_of_two(
    motion: Path, sound: Path, seconds: float, faults: Faults, *, seed: int = 1, options: Sequence[object] = ()
) -> tuple[Lines, Lines]:
    """Make a call of two with the same motion and sound both ways; return the log lines of who calls and who is called.

    options : further arguments of call_end_probe.py
    """
    program, common = call_end_probe.__file__, [motion, "--sound", sound, *options]
    called = start("listen", CODE, seconds + STARTING_S, *common, program=program)
    assert called.stdout is not None
    address = json.loads(called.stdout.readline())["listening"]
    relay = Relay(("127.0.0.1", 0), split_address(address), faults, seed=seed)
    calling = start("{}:{}".format(*relay.address), CODE, seconds, *common, program=program)
    return _logs(calling, called, relay, seconds)


def _logs(
    sender: subprocess.Popen[str], receiver: subprocess.Popen[str], relay: Relay, seconds: float
) -> tuple[Lines, Lines]:
    """Relay until the sender ends; return the log lines of both."""
    sent: Lines = []
    received: Lines = []
    machine: list[list[float]] = []
    finished = threading.Event()
    assert sender.stdout is not None and receiver.stdout is not None
    threads = [
        threading.Thread(target=_relay_until, args=(relay, finished)),
        threading.Thread(target=_watch_machine, args=(machine, finished)),
        threading.Thread(target=read_lines, args=(sender.stdout, sent)),
        threading.Thread(target=read_lines, args=(receiver.stdout, received)),
    ]
    try:
        for thread in threads:
            thread.start()
        sender.wait(seconds + STARTING_S)
    finally:
        finished.set()
        for process in (sender, receiver):
            process.kill()
        for thread in threads:
            thread.join()
        for process in (sender, receiver):
            process.communicate()
        relay.close()
    for line in [*sent, *received]:
        line["machine_gaps"] = [gap for gap in machine if line["at"] - 1 < gap[0] <= line["at"]]
    return sent, received


def _watch_machine(gaps: list[list[float]], finished: threading.Event) -> None:
    """Append (time, s) whenever this thread wakes up too late."""
    last = time.monotonic()
    while not finished.wait(SLEEP_S):
        now = time.monotonic()
        if now - last > 2 * SLEEP_S:
            gaps.append([now, now - last - SLEEP_S])
        last = now


def _relay_until(relay: Relay, finished: threading.Event) -> None:
    while not finished.is_set():
        relay.run(0.5)


@contextmanager
def extracted(clip: Path) -> Iterator[tuple[Path, Path]]:
    """Extract motion and sound of a clip into files that exist while the block runs."""
    with TemporaryDirectory() as folder:
        motion, sound = Path(folder, "motion.dpc"), Path(folder, "sound.wav")
        extract(clip, motion, sound=sound)
        yield motion, sound


def figures(sent: Lines, received: Lines, *, rows: int = ROWS) -> dict[str, Any]:
    """Return the rows and the totals."""
    captures = [frame for line in sent for frame in line["frames"]]
    start_time = captures[0][0]
    end = captures[-1][0]
    length = (end - start_time) / rows
    table = [_row(sent, received, captures, start_time + i * length, length) for i in range(rows)]
    steady = [row for row in table if row["from_s"] >= START_S] or table
    last = max(received, key=lambda line: line["frames_received"])  # later ones no longer count a call that has ended
    return {
        "minutes": round((end - start_time) / 60, 2),
        "frames_sent": sent[-1]["frames_sent"],
        "frames_received": last["frames_received"],
        "frames_lost": last["frames_lost"],
        "frames_late": last["frames_late"],
        "rejected": last["rejected"],
        **{name: max(row[name] for row in table) for name in ("longest_capture_gap_s", "longest_stall_s")},
        "latency_drift_ms": round(steady[-1]["latency_ms"] - steady[0]["latency_ms"], 1),
        "receiver_growth_kb": steady[-1]["receiver_kb"] - steady[0]["receiver_kb"],
        "sender_growth_kb": steady[-1]["sender_kb"] - steady[0]["sender_kb"],
        **sound_totals(steady),
        "rows": table,
    }


def _row(sent: Lines, received: Lines, captures: list[list[float]], begin: float, length: float) -> dict[str, float]:
    receiver = [line for line in received if begin <= line["at"] <= begin + length]
    sender = [line for line in sent if begin <= line["at"] <= begin + length]
    images = [image for line in received for image in line["pictures"] if begin <= image[0] <= begin + length]
    frames_sent = sorted(time for line in sent for time in line["sent"])
    times = [at for at, _ in captures if begin <= at <= begin + length]
    counted = ("frames_received", "frames_lost", "frames_late")
    counts = {name: receiver[-1][name] - receiver[0][name] if receiver else 0 for name in counted}
    return {
        "from_s": round(begin - captures[0][0], 1),
        "sender_kb": max((line["memory_kb"] for line in sender), default=0),
        "receiver_kb": max((line["memory_kb"] for line in receiver), default=0),
        **counts,
        "playout_delay_ms": round(median([line["playout_delay_ms"] for line in receiver] or [0]), 1),
        "latency_ms": round(latency(captures, images) * 1000, 1),
        "longest_capture_gap_s": round(max((b - a for a, b in pairwise(times)), default=0.0), 3),
        "longest_stall_s": round(longest_stall(frames_sent, images), 3),
        "machine_gap_s": round(
            max((gap[1] for line in receiver for gap in line.get("machine_gaps", [])), default=0), 3
        ),
        **sound_row(received, begin, begin + length),
    }


def longest_stall(frames_sent: list[float], images: list[list[float]]) -> float:
    """Return the longest time of the playhead past a frame that was sent and has not arrived, s.

    frames_sent : stream times, in order; images : (finished at, playhead, s the playhead is past the newest frame)
    """
    longest = 0.0
    for _, playhead, past in images:
        missing = bisect_right(frames_sent, playhead - past + HALF_FRAME_S)
        if past > 0 and missing < len(frames_sent):
            longest = max(longest, playhead - frames_sent[missing])
    return longest


def latency(captures: list[list[float]], images: list[list[float]]) -> float:
    """Return the median time from the capture of the frame that an image shows to the image, s."""
    timestamps = [timestamp - captures[0][1] for _, timestamp in captures]
    latencies = []
    for at, playhead, _ in images:
        newest = bisect_right(timestamps, playhead) - 1  # the newest frame that the playhead has reached
        if newest >= 0:
            latencies.append(at - captures[newest][0] - (playhead - timestamps[newest]))
    return median(latencies) if latencies else 0.0


def main() -> None:
    """Make the call and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--delay-ms", type=float, default=40.0)
    parser.add_argument("--jitter-ms", type=float, default=10.0)
    parser.add_argument("--clip", type=Path)
    parser.add_argument(
        "--sound",
        nargs="?",
        const="",
        metavar="SPEAKER",
        help="play the clip's voice (default: on the system's loudspeaker)",
    )
    parser.add_argument("--kbps", type=float, help="limit of the sender, with --sound")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--call", action="store_true", help="a call of two, with --sound")
    options = parser.parse_args()
    faults = Faults(loss=options.loss, delay_ms=options.delay_ms, jitter_ms=options.jitter_ms)
    seconds, rows = options.minutes * 60, max(1, math.ceil(options.minutes))
    if options.sound is None and not options.call:
        results = {"": figures(*call(options.clip or fetch_carphone(), seconds, faults))}
    elif options.clip is None:
        parser.error("--sound and --call need a clip with sound: --clip CLIP")
    else:
        limit = [] if options.kbps is None else ["--kbps", options.kbps]
        speaker = ["--speaker", options.sound or ("null" if options.call else "")]
        with extracted(options.clip) as (motion, sound):
            if options.call:
                calling, called = call_of_two(motion, sound, seconds, faults, options=[*speaker, *limit])
            else:
                calling, called = call(
                    motion,
                    seconds,
                    faults,
                    sender_options=["--sound", sound, *limit],
                    receiver_options=[*speaker, "--fps", SOUND_FPS],
                )
        results = {"to_called" if options.call else "": figures(calling, called, rows=rows)}
        if options.call:
            results["to_calling"] = figures(called, calling, rows=rows)
    if options.json:
        print(json.dumps(results.get("", results), indent=1))
        return
    for title, result in results.items():
        columns = list(result["rows"][0])
        print(title + "\n" + "  ".join(columns) if title else "  ".join(columns))
        for row in result["rows"]:
            print("  ".join(f"{row[name]:>{len(name)}}" for name in columns))
        print(", ".join(f"{name} {value}" for name, value in result.items() if name != "rows"))


if __name__ == "__main__":
    main()
