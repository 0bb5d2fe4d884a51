"""Measure how long it takes from the second command of a call until both ends draw each other.

    python tools/bench/call_setup.py CLIP [--runs 20] [--loss 0.1] [--seconds 8] [--json]

Two processes run `conf call` on this machine, as a user types it, without windows: both draw into a file. The first
waits for the call, with its head loaded; time begins when the second is started, and includes the start of Python. With
--loss, a relay between them drops so many of the datagrams of each direction. To be reached on a quiet machine: 1.5 s
without loss; at 10 % loss 5 s in 20 of 20 runs.
"""

import argparse
import json
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

ROOT = Path(__file__).resolve().parents[2]
CODE = "acorn-tulip-river-42"
LIMITS_S = {0.0: 1.5, 0.1: 5.0}
BEGAN = "began "


@dataclass(frozen=True)
class Setup:
    """Seconds from the start of the second command; None for what did not happen."""

    connected_s: float | None
    caller_draws_s: float | None
    both_draw_s: float | None


def main() -> None:
    """Print the table, or one JSON object; as a child, run `conf`."""
    if sys.argv[1:2] == ["--child"]:
        run_conf(sys.argv[2:])
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--loss", type=float, default=0.0, help="fraction of the datagrams of each direction")
    parser.add_argument("--seconds", type=float, default=8.0, help="duration of each call (default 8)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    runs = [measure(options.clip, options.loss, options.seconds, seed) for seed in range(options.runs)]
    result = summary(runs, options.loss)
    print(json.dumps(result | {"each": [asdict(run) for run in runs]}) if options.json else table(result))


def run_conf(arguments: list[str]) -> None:
    """Run `conf` and tell when its command began, on the clock that all processes share."""
    from conf import cli
    from conf.commands import call

    run = call.run

    def timed(options: argparse.Namespace, terminal: Any) -> None:
        print(f"{BEGAN}{time.monotonic()}", file=sys.stderr, flush=True)
        run(options, terminal)

    call.run = timed
    cli.main(arguments)


def measure(clip: Path, loss: float, seconds: float, seed: int) -> Setup:
    """Hold one call and return its times."""
    with tempfile.TemporaryDirectory() as folder:
        waits = start(["--listen", "127.0.0.1:0"], clip, Path(folder) / "a.mp4")
        assert waits.stderr is not None
        waiting_began = read_until(waits, BEGAN)
        address = read_until(waits, "listening on ").split(",")[0]
        with relay(address, loss, seed) as reached:
            started = time.monotonic()
            calls = start([reached, "--seconds", str(seconds)], clip, Path(folder) / "b.mp4")
            calling_began = read_until(calls, BEGAN)
            called, _ = calls.communicate()
        waits.send_signal(signal.SIGINT)
        waited, _ = waits.communicate()
    first = json.loads(waited) if waited else {}
    second = json.loads(called) if called else {}
    connected = absolute(calling_began, second.get("connecting_s"))
    drawn = [absolute(calling_began, second.get("picture_s")), absolute(waiting_began, first.get("picture_s"))]
    both = None if None in drawn else max(at for at in drawn if at is not None)
    return Setup(*(None if at is None else round(at - started, 3) for at in (connected, drawn[0], both)))


def absolute(began: str, seconds: float | None) -> float | None:
    """Return a time on the clock of all processes."""
    return None if seconds is None else float(began) + seconds


def start(arguments: list[str], clip: Path, output: Path) -> subprocess.Popen[str]:
    """Start one end."""
    command = [sys.executable, "-P", __file__, "--child", "call", *arguments, "--code", CODE]
    command += ["--file", str(clip), "--loop", "--headless", str(output), "--json"]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # who uses the program has it compiled
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def read_until(process: subprocess.Popen[str], prefix: str) -> str:
    """Return the rest of the first line of a process's messages that begins with a prefix."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith(prefix):
            return line.removeprefix(prefix).strip()
    sys.exit("conf call ended before it was ready: run it alone to see why")


@contextmanager
def relay(address: str, loss: float, seed: int) -> Iterator[str]:
    """Yield the address at which the waiting end is reached: its own, or that of a relay that loses datagrams."""
    if not loss:
        yield address
        return
    from tools.network.impair import Faults, Relay

    host, port = address.rsplit(":", 1)
    between = Relay(("127.0.0.1", 0), (host, int(port)), Faults(loss=loss), seed=random.Random(seed).getrandbits(30))
    thread = threading.Thread(target=between.run, args=(120.0,), daemon=True)
    thread.start()
    yield "{}:{}".format(*between.address)


def summary(runs: list[Setup], loss: float) -> dict[str, Any]:
    """Return medians and maxima, and how many runs were within the limit for this loss."""
    limit = LIMITS_S.get(loss)
    both = [run.both_draw_s for run in runs]
    result: dict[str, Any] = {"runs": len(runs), "loss": loss, "limit_s": limit}
    for name in ("connected_s", "caller_draws_s", "both_draw_s"):
        values = [value for run in runs if (value := getattr(run, name)) is not None]
        result[name] = {"median": round(statistics.median(values), 3), "max": max(values)} if values else None
    result["failed"] = both.count(None)
    result["within"] = None if limit is None else sum(at is not None and at <= limit for at in both)
    return result


def table(result: dict[str, Any]) -> str:
    """Return the results as text."""
    lines = [f"{result['runs']} calls at a loss of {100 * result['loss']:.0f} %, {result['failed']} failed"]
    for name in ("connected_s", "caller_draws_s", "both_draw_s"):
        if figures := result[name]:
            lines.append(f"{name:<16} median {figures['median']:.2f}   max {figures['max']:.2f}")
    if result["limit_s"] is not None:
        lines.append(f"within {result['limit_s']} s: {result['within']} of {result['runs']}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
