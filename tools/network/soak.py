"""A long call over a bad link: a looped clip through tools/network/impair.py, and what changes with time.

    python tools/network/soak.py [--minutes 60] [--loss 0.05] [--clip CLIP] [--json]

Sender and receiver are two processes (tools/bench/call_probe.py). Each row is a share of the call: memory of both ends,
frames received, lost and late, playout delay, the median time from a frame's capture to the picture that shows it, the
longest time between two captures, and the longest stall: how long the playhead was past the newest frame. In a call of
any length no column may grow; a stall beside a capture gap as long is the machine's, which stood still for both.
"""

import argparse
import json
import sys
import threading
from bisect import bisect_right
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.sender.tracking.model_files import fetch_demo_clip
from tools.bench.call_probe import read_lines, split_address, start, start_receiver
from tools.network.impair import Faults, Relay

CODE = "amber-canoe-tiger-7"
ROWS = 10
STARTING_S = 60.0  # that processes may take to start on a busy machine
START_S = 3.0  # a call's first seconds: handshake, calibration, memory that is taken once
Lines = list[dict[str, Any]]


def call(clip: Path, seconds: float, faults: Faults, *, seed: int = 1, portrait: bool = False) -> tuple[Lines, Lines]:
    """Make a call through a relay; return what sender and receiver told."""
    receiver, address = start_receiver(CODE, seconds + STARTING_S)
    relay = Relay(("127.0.0.1", 0), split_address(address), faults, seed=seed)
    sender = start("send", "{}:{}".format(*relay.address), CODE, seconds, clip, *(["--portrait"] if portrait else []))
    sent: Lines = []
    received: Lines = []
    over = threading.Event()
    assert sender.stdout is not None and receiver.stdout is not None
    threads = [
        threading.Thread(target=_relay_until, args=(relay, over)),
        threading.Thread(target=read_lines, args=(sender.stdout, sent)),
        threading.Thread(target=read_lines, args=(receiver.stdout, received)),
    ]
    try:
        for thread in threads:
            thread.start()
        sender.wait(seconds + STARTING_S)
    finally:
        over.set()
        for process in (sender, receiver):
            process.kill()
        for thread in threads:
            thread.join()
        for process in (sender, receiver):
            process.communicate()
        relay.close()
    return sent, received


def _relay_until(relay: Relay, over: threading.Event) -> None:
    while not over.is_set():
        relay.run(0.5)


def figures(sent: Lines, received: Lines) -> dict[str, Any]:
    """Return the rows and what they say together."""
    captures = [frame for line in sent for frame in line["frames"]]
    began = captures[0][0]
    end = captures[-1][0]
    length = (end - began) / ROWS
    rows = [_row(sent, received, captures, began + i * length, length) for i in range(ROWS)]
    steady = [row for row in rows if row["from_s"] >= START_S] or rows
    last = received[-1]
    return {
        "minutes": round((end - began) / 60, 2),
        "frames_sent": sent[-1]["frames_sent"],
        "frames_received": last["frames_received"],
        "frames_lost": last["frames_lost"],
        "frames_late": last["frames_late"],
        "rejected": last["rejected"],
        **{name: max(row[name] for row in rows) for name in ("longest_capture_gap_s", "longest_stall_s")},
        "latency_drift_ms": round(steady[-1]["latency_ms"] - steady[0]["latency_ms"], 1),
        "receiver_growth_kb": steady[-1]["receiver_kb"] - steady[0]["receiver_kb"],
        "sender_growth_kb": steady[-1]["sender_kb"] - steady[0]["sender_kb"],
        "rows": rows,
    }


def _row(sent: Lines, received: Lines, captures: list[list[float]], begin: float, length: float) -> dict[str, float]:
    ours = [line for line in received if begin <= line["at"] <= begin + length]
    theirs = [line for line in sent if begin <= line["at"] <= begin + length]
    pictures = [p for line in received for p in line["pictures"] if begin <= p[0] <= begin + length]
    stamps = [at for at, _ in captures if begin <= at <= begin + length]
    counted = ("frames_received", "frames_lost", "frames_late")
    counts = {name: ours[-1][name] - ours[0][name] if ours else 0 for name in counted}
    return {
        "from_s": round(begin - captures[0][0], 1),
        "sender_kb": max((line["memory_kb"] for line in theirs), default=0),
        "receiver_kb": max((line["memory_kb"] for line in ours), default=0),
        **counts,
        "playout_delay_ms": round(median([line["playout_delay_ms"] for line in ours] or [0]), 1),
        "latency_ms": round(latency(captures, pictures) * 1000, 1),
        "longest_capture_gap_s": round(max((b - a for a, b in pairwise(stamps)), default=0.0), 3),
        "longest_stall_s": round(max((p[2] for p in pictures), default=0.0), 3),
    }


def latency(captures: list[list[float]], pictures: list[list[float]]) -> float:
    """Return the median time from the capture of what a picture shows to the picture."""
    stamps = [stamp - captures[0][1] for _, stamp in captures]
    behind = []
    for at, playhead, _ in pictures:
        newest = bisect_right(stamps, playhead) - 1  # the newest frame that the picture's playhead has reached
        if newest >= 0:
            behind.append(at - captures[newest][0] - (playhead - stamps[newest]))
    return median(behind) if behind else 0.0


def main() -> None:
    """Make the call and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--delay-ms", type=float, default=40.0)
    parser.add_argument("--jitter-ms", type=float, default=10.0)
    parser.add_argument("--clip", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    faults = Faults(loss=options.loss, delay_ms=options.delay_ms, jitter_ms=options.jitter_ms)
    result = figures(*call(options.clip or fetch_demo_clip(), options.minutes * 60, faults))
    if options.json:
        print(json.dumps(result, indent=1))
        return
    columns = list(result["rows"][0])
    print("  ".join(columns))
    for row in result["rows"]:
        print("  ".join(f"{row[name]:>{len(name)}}" for name in columns))
    print(", ".join(f"{name} {value}" for name, value in result.items() if name != "rows"))


if __name__ == "__main__":
    main()
