"""Measure what `conf call` costs by a capture outside the program: two network namespaces, a raw socket between them.

    python tools/bench/call_capture.py [--profiles live narrow] [--seconds 40] [--json]

Needs root. Each end sends the motion of a track of ../shared/motion, without voice, and draws into a clip. The kernel's
copies of all IPv4 packets on the virtual cable are counted for some seconds from the first sealed datagram of both ends
on: names, parameters and reports included, handshake not.
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import uuid4

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.face.formats.dpc import MotionClip, write_dpc
from tools.bench.tracks import TrackReader
from tools.bench.two_way_call import MAX_KBPS, PROFILE_FPS, TALKERS
from tools.bench.voice import SHARED

ROOT = Path(__file__).resolve().parents[2]
CODE = "amber-canoe-tiger-7"
HOSTS = ("10.78.0.1", "10.78.0.2")
PORT = 5005
ETHERTYPE_ALL, ETHERTYPE_IPV4, UDP, PACKET_OUTGOING = 3, 0x0800, 17, 4  # only "all" gets outgoing packets
SEALED = 0x94  # the first byte of a sealed datagram
START_LIMIT_S = 90.0


def count_packets(interface: str, seconds: float) -> dict[str, float]:
    """Return kbit/s of what leaves and of what enters an interface, IPv4 headers included."""
    totals, seen, until = {"out": 0, "in": 0}, set[str](), float("inf")
    with socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETHERTYPE_ALL)) as packets:
        packets.bind((interface, ETHERTYPE_ALL))
        packets.settimeout(1.0)
        give_up = time.monotonic() + START_LIMIT_S + seconds
        while time.monotonic() < min(until, give_up):
            try:
                data, (_, ethertype, kind, *_) = packets.recvfrom(2048)
            except TimeoutError:
                continue
            if ethertype != ETHERTYPE_IPV4 or data[9] != UDP:
                continue
            header = 4 * (data[0] & 15)
            direction = "out" if kind == PACKET_OUTGOING else "in"
            if data[header + 8] == SEALED and len(seen) < 2:
                seen.add(direction)
                until = time.monotonic() + seconds if len(seen) == 2 else until
            if len(seen) == 2:
                totals[direction] += int.from_bytes(data[2:4])
    return {direction: size * 8 / 1000 / seconds for direction, size in totals.items()}


@contextmanager
def cable() -> Iterator[tuple[str, str, str]]:
    """Connect two new network namespaces. Yields their names, and the interface of the first."""
    mark = uuid4().hex[:6]
    names, ends = (f"conf-a-{mark}", f"conf-b-{mark}"), (f"ca{mark}", f"cb{mark}")
    commands = [f"ip netns add {name}" for name in names]
    commands.append(f"ip link add {ends[0]} netns {names[0]} type veth peer name {ends[1]} netns {names[1]}")
    for name, end, host in zip(names, ends, HOSTS, strict=True):
        commands.append(f"ip -n {name} addr add {host}/24 dev {end}")
        commands += [f"ip -n {name} link set {device} up" for device in (end, "lo")]
    try:
        for command in commands:
            subprocess.run(command.split(), check=True)
        yield *names, ends[0]
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)


def measure(profile: str, seconds: float) -> dict[str, float]:
    """Hold one call and return kbit/s of each talker."""
    reader = TrackReader()
    with TemporaryDirectory() as folder, cable() as (first, second, interface):
        calls = []
        for talker, namespace, remote in zip(TALKERS, (first, second), (None, HOSTS[0]), strict=True):
            track = reader.read(SHARED / "motion" / f"{talker}.npz", fps=PROFILE_FPS)
            motion = Path(folder) / f"{talker}.dpc"
            frames = track.frames
            displacements = np.stack([frame.displacements for frame in frames])
            write_dpc(
                motion, MotionClip(PROFILE_FPS, "fapu", displacements, np.stack([frame.pose for frame in frames]))
            )
            where = [f"{remote}:{PORT}"] if remote else ["--listen", f"{HOSTS[0]}:{PORT}"]
            options = ["--code", CODE, "--dpc", str(motion), "--loop", "--no-sound", "--profile", profile]
            options += ["--headless", str(Path(folder) / f"{talker}.mp4"), "--seconds", str(seconds + START_LIMIT_S)]
            command = [sys.executable, "-m", "conf", "call", *where, *options]
            calls.append(
                subprocess.Popen(
                    ["ip", "netns", "exec", namespace, *command],
                    cwd=ROOT,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                )
            )
        try:
            counter = [sys.executable, __file__, "--count", interface, "--seconds", str(seconds)]
            counted = subprocess.run(
                ["ip", "netns", "exec", first, *counter], check=True, stdout=subprocess.PIPE, cwd=ROOT
            )
        finally:
            for call in calls:
                call.terminate()
            errors = [call.communicate()[1] for call in calls]
        found = json.loads(counted.stdout)
    if not all(found.values()):
        sys.exit("\n".join(["there was no call", *errors]))
    return dict(zip(TALKERS, (found["out"], found["in"]), strict=True))


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profiles", nargs="+", default=list(MAX_KBPS), choices=list(MAX_KBPS))
    parser.add_argument("--seconds", type=float, default=40.0)
    parser.add_argument("--count", metavar="INTERFACE", help="count packets here, used by the program itself")
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    options = parser.parse_args()
    if options.count:
        print(json.dumps(count_packets(options.count, options.seconds)))
        return
    rows = {}
    for profile in options.profiles:
        rows[profile] = measure(profile, options.seconds)
        if not options.json:
            each = " and ".join(f"{kbps:.2f}" for kbps in rows[profile].values())
            print(f"{profile:7} each direction {each} kbit/s (at most {MAX_KBPS[profile]})", flush=True)
    if options.json:
        print(json.dumps({"captured_kbps": rows}))


if __name__ == "__main__":
    main()
