"""How soon is the caller's own face shown? Calls over a slow link that loses, from the first datagram on.

    python tools/bench/portrait_start.py [CLIP...] [--calls 10] [--kbps 16] [--loss 0.05] [--delay-ms 40] [--json]

Sender and receiver are two processes (tools/bench/call_probe.py) that do what `conf send --portrait` and `conf receive`
do, tools/network/impair.py between them: its rate counts UDP/IP headers, what waits for longer than a second is
dropped, and both ways are impaired alike. Each call has its own seed; the clips take turns. Counted is from the moment
the sender begins to call, handshake included, to the end of the first picture that shows the portrait. Beside it: how
long motion waits until it is through the link, as the sender's datagrams would queue there one by one, and how much of
that is the picture's doing: the same queue without it.
"""

import argparse
import json
import sys
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.sender.tracking.model_files import fetch_demo_clip
from tools.network.impair import Faults
from tools.network.soak import Lines, call

SECONDS = 15.0  # of each call
TARGET_S = 6.0
TARGET_ADDED_MS = 67  # a frame's time


SUMMARY = "median {median_s} s, worst {worst_s} s; the picture added {added_ms_worst} ms to motion's way at the worst"


def started(sent: Lines, received: Lines) -> dict[str, float | None]:
    """Return the seconds of one call from its beginning to the first frame taken, and to the portrait shown."""
    began = sent[0]["began"]
    shown = min((at for line in received for at in line["portraits"].values()), default=None)
    return {
        "connected_s": round(sent[0]["frames"][0][0] - began, 2),
        "shown_s": None if shown is None else round(shown - began, 2),
    }


def waits(sent: Lines, kbps: float) -> tuple[list[float], list[float]]:
    """Return for each datagram of motion the seconds until it is through the link, and those that the picture adds."""
    rate = kbps * 125
    free_at = alone_at = 0.0  # when the link has sent everything, and when it would have without the picture
    through, added = [], []
    for at, size, pieces in (datagram for line in sent for datagram in line["datagrams"]):
        free_at = max(free_at, at) + size / rate
        if size > pieces:
            alone_at = max(alone_at, at) + (size - pieces) / rate
            through.append(free_at - at)
            added.append(free_at - alone_at)
    return through, added


def figures(calls: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the calls and what they say together; a portrait that was never shown counts as a whole call."""
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
    """Make the calls and print how they began."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", type=Path, nargs="*")
    parser.add_argument("--calls", type=int, default=10)
    parser.add_argument("--kbps", type=float, default=16.0)
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--delay-ms", type=float, default=40.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    faults = Faults(loss=options.loss, delay_ms=options.delay_ms, kbps=options.kbps)
    clips = options.clips or [fetch_demo_clip()]
    calls = []
    for number in range(options.calls):
        clip = clips[number % len(clips)]
        sent, received = call(clip, SECONDS, faults, seed=2 * number + 1, portrait=True)
        times = started(sent, received)
        through, added = ([1000 * seconds for seconds in part] for part in waits(sent, options.kbps))
        motion = {"motion_ms_p95": round(float(np.percentile(through, 95))), "added_ms_worst": round(max(added))}
        calls.append({"seed": 2 * number + 1, "clip": clip.stem, **times, **motion})
        if not options.json:
            print("  ".join(f"{name} {value}" for name, value in calls[-1].items()), flush=True)
    result = figures(calls)
    print(json.dumps(result) if options.json else SUMMARY.format(**result))


if __name__ == "__main__":
    main()
