"""Measure how long the command line takes to answer: medians, with Python's own start in the same run.

    python tools/bench/start.py [--runs N] [--json]

`conf receive` is timed until its line with the pairing code is there, before it loads the head. To be reached on a
quiet machine: 0.25 s for `conf --help`, 1 s for the code.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = [sys.executable, "-P"]
CONF = [*PYTHON, "-m", "conf"]
COMMANDS = {
    "python -c pass": [*PYTHON, "-c", "pass"],
    "conf --help": [*CONF, "--help"],
    "conf --version": [*CONF, "--version"],
    "conf receive --listen PORT": [*CONF, "receive", "--listen", "0"],
}


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--runs", type=int, default=10, help="runs of each command, in turn (default 10)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(options.runs):
        for name, command in COMMANDS.items():
            times[name].append(first_output(command))
    medians = {name: round(statistics.median(values), 3) for name, values in times.items()}
    if options.json:
        print(json.dumps(medians))
        return
    for name, values in times.items():
        print(f"{name:<28}{medians[name]:>7.3f} s   fastest {min(values):.3f} s")


def first_output(command: list[str]) -> float:
    """Return the seconds until a command has printed its first line, or ended without one."""
    # a display, or the command would refuse before it prints the code; none is opened, as the process is ended then
    environment = {"DISPLAY": ":0"} | os.environ | {"PYTHONPATH": str(ROOT)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # who uses the program has it compiled
    start = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        if b"code" not in line:
            process.wait()
        end = time.perf_counter()
        process.kill()
    return end - start


if __name__ == "__main__":
    main()
