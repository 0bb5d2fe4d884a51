"""Measure the time from the start of a call until the portrait is shown, over a slow link with losses.

    python tools/bench/portrait_start.py [CLIP...] [--calls 10] [--kbps 16] [--loss 0.05] [--delay-ms 40] [--json]

Sender and receiver are two processes (tools/bench/call_probe.py) that do what `conf send --portrait` and `conf receive`
do, with tools/network/impair.py between them: its rate includes UDP/IP headers, datagrams queued for more than 1 s are
dropped, and both directions are impaired alike. Each call has its own seed; the clips are used in turn. The time runs
from the start of the call in the sender, handshake included, to the end of the first image that shows the portrait.
Also printed: the time that motion needs through the link, simulated as a queue of the sender's datagrams, and the part
of it that the portrait adds: the difference to the same queue without the portrait.
"""

import argparse
import json
import sys
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from tools.bench.carphone import fetch_carphone
from tools.network.impair import Faults
from tools.network.soak import Lines, call

SECONDS = 15.0  # of each call
TARGET_S = 6.0
TARGET_ADDED_MS = 67  # one frame at 15 frames/s
SUMMARY = "median {median_s} s, worst {worst_s} s; the portrait delayed motion by {added_ms_worst} ms at most"


def start_times(sent: Lines, received: Lines) -> dict[str, float | None]:
    """Return the seconds from the start of a call to the first captured frame, and to the portrait."""
    began = sent[0]["began"]
    shown = min((at for line in received for at in line["portraits"].values()), default=None)
    return {
        "connected_s": round(sent[0]["frames"][0][0] - began, 2),
        "shown_s": None if shown is None else round(shown - began, 2),
    }


def motion_delays(sent: Lines, kbps: float) -> tuple[list[float], list[float]]:
    """Return for each datagram of motion the seconds through the link, and those that the portrait adds."""
    rate = kbps * 125
    free_at = alone_at = 0.0  # times at which the link is free, with and without the portrait
    delays, added = [], []
    for at, size, chunks in (datagram for line in sent for datagram in line["datagrams"]):
        free_at = max(free_at, at) + size / rate
        if size > chunks:
            alone_at = max(alone_at, at) + (size - chunks) / rate
            delays.append(free_at - at)
            added.append(free_at - alone_at)
    return delays, added


def figures(calls: list[dict[str, Any]]) -> dict[str, Any]:
    """Return all calls and their totals; a portrait that was never shown counts as SECONDS."""
    times = [one["shown_s"] or SECONDS for one in calls]
    return {
        "median_s": round(median(times), 2),
        "worst_s": max(times),
        "target_s": TARGET_S,
        "added_ms_worst": max(one["added_ms_worst"] for one in calls),
        "target_added_ms": TARGET_ADDED_MS,
        "calls": calls,
    }


def main() -> None:
    """Make the calls and print the times of their start."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", type=Path, nargs="*")
    parser.add_argument("--calls", type=int, default=10)
    parser.add_argument("--kbps", type=float, default=16.0)
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--delay-ms", type=float, default=40.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    faults = Faults(loss=options.loss, delay_ms=options.delay_ms, kbps=options.kbps)
    clips = options.clips or [fetch_carphone()]
    calls = []
    for number in range(options.calls):
        clip = clips[number % len(clips)]
        sent, received = call(clip, SECONDS, faults, seed=2 * number + 1, sender_options=["--portrait"])
        times = start_times(sent, received)
        delays, added = ([1000 * seconds for seconds in part] for part in motion_delays(sent, options.kbps))
        motion = {"motion_ms_p95": round(float(np.percentile(delays, 95))), "added_ms_worst": round(max(added))}
        calls.append({"seed": 2 * number + 1, "clip": clip.stem, **times, **motion})
        if not options.json:
            print("  ".join(f"{name} {value}" for name, value in calls[-1].items()), flush=True)
    result = figures(calls)
    print(json.dumps(result) if options.json else SUMMARY.format(**result))


if __name__ == "__main__":
    main()
