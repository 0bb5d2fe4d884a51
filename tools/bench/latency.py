"""Measure what a call adds between a frame's capture and the picture that shows it, on loopback, at `live`.

    python tools/bench/latency.py [--seconds 20] [--json]

Two processes (tools/bench/call_probe.py) share the machine's monotonic clock. For each frame: from the moment its turn
comes in the sender, before it is tracked, to the first finished picture whose playhead has reached it. The camera's own
time is not in it; the wait for the next picture is.
"""

import argparse
import json
import sys
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.sender.tracking.model_files import fetch_demo_clip
from tools.network.impair import Faults
from tools.network.soak import Lines, call

SETTLE_S = 5.0  # the first frames load models and fill caches
TARGET_MS = 67.0


def latencies(sent: Lines, received: Lines) -> list[float]:
    """Return for each frame the seconds from its capture to the picture that shows it."""
    captures = [frame for line in sent for frame in line["frames"]]
    pictures = [picture for line in received for picture in line["pictures"]]
    result, at = [], 0
    for captured, stamp in captures:
        stream_time = stamp - captures[0][1]
        while at < len(pictures) and pictures[at][1] < stream_time:
            at += 1
        if at < len(pictures) and captured > captures[0][0] + SETTLE_S:
            result.append(pictures[at][0] - captured)
    return result


def figures(sent: Lines, received: Lines) -> dict[str, Any]:
    """Return the quantiles in milliseconds and what they are made of."""
    times = sorted(1000 * seconds for seconds in latencies(sent, received))
    return {
        "frames": len(times),
        "median_ms": round(median(times), 1),
        "p95_ms": round(times[int(0.95 * len(times))], 1),
        "target_ms": TARGET_MS,
        "tracker_ms_median": round(sent[-1]["tracker_ms_median"], 1),
        "playout_delay_ms_median": round(median(line["playout_delay_ms"] for line in received[-10:]), 1),
    }


def main() -> None:
    """Make a call and print its latency."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--clip", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    result = figures(*call(options.clip or fetch_demo_clip(), options.seconds, Faults()))
    print(json.dumps(result) if options.json else "\n".join(f"{name:26} {value}" for name, value in result.items()))


if __name__ == "__main__":
    main()
