"""Measure the latency that a call adds from a frame's capture to the image that shows it, on loopback, at `live`.

    python tools/bench/latency.py [--seconds 20] [--json]

Two processes (tools/bench/call_probe.py) share the machine's monotonic clock. Latency of a frame: from its capture in
the sender, before tracking, to the end of the first image whose playhead has reached it. The latency of the camera is
not included; the wait for the next image is.
"""

import argparse
import json
import sys
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tools.bench.carphone import fetch_carphone
from tools.network.impair import Faults
from tools.network.soak import Lines, call

SETTLE_S = 5.0  # excluded: the first frames load models and fill caches
TARGET_MS = 67.0


def latencies(sent: Lines, received: Lines) -> list[float]:
    """Return for each frame the seconds from its capture to the image that shows it."""
    captures = [frame for line in sent for frame in line["frames"]]
    images = [image for line in received for image in line["pictures"]]
    result, index = [], 0
    for captured, timestamp in captures:
        stream_time = timestamp - captures[0][1]
        while index < len(images) and images[index][1] < stream_time:
            index += 1
        if index < len(images) and captured > captures[0][0] + SETTLE_S:
            result.append(images[index][0] - captured)
    return result


def figures(sent: Lines, received: Lines) -> dict[str, Any]:
    """Return the quantiles of the latency and its main parts, ms."""
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
    result = figures(*call(options.clip or fetch_carphone(), options.seconds, Faults()))
    print(json.dumps(result) if options.json else "\n".join(f"{name:26} {value}" for name, value in result.items()))


if __name__ == "__main__":
    main()
