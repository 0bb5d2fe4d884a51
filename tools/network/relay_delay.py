"""Measure what a relay adds to the delay of a datagram: two hosts behind two NATs (Linux, root, iptables).

    python tools/network/relay_delay.py [--seconds 20] [--json]

The namespaces are those of nat_calls.py, with NATs that let a direct path through, so that both can be measured at
once: each end sends 15 times a second 50 B over the relay, and the same directly. The delay is from just before a
datagram is sent to just after it was received, in Python. Between symmetric NATs datagrams pass the same hosts.
"""

import argparse
import json
import os
import select
import statistics
import struct
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.transport.interface import HasFileno
from conf.transport.udp import UdpSocket
from conf.transport.zenoh_transport import RelayTransport
from tools.network.nat_calls import SERVER, build, start, start_relay, tear_down

PLATE = "4711"
PORT = 5600
OUTSIDE = {"wait": "192.0.2.12", "call": "192.0.2.11"}  # where the other end's NAT is
RATE = 15.0
SIZE = 50
WARM_UP_S = 3.0
MAX_ADDED_MS = 10.0
STAMP = struct.Struct(">d")


@dataclass(frozen=True)
class Delays:
    """Of both directions. added : the 95th percentile over the relay, less that of the direct path; loss : share"""

    relay_p50_ms: float
    relay_p95_ms: float
    direct_p50_ms: float
    direct_p95_ms: float
    added_p95_ms: float
    relay_loss: float
    direct_loss: float
    reaches: bool


@dataclass(frozen=True)
class EndDelays:
    """Of one end. sent : datagrams on each way; relay, direct : delays of those received, s"""

    sent: int
    relay: list[float]
    direct: list[float]


def probe(role: str, seconds: float) -> None:
    """Be one end. Prints how many datagrams were sent each way, and the delays of those received, s."""
    relay = (SERVER, 7447)
    is_caller = role == "call"
    transport = RelayTransport.call(relay, PLATE, os.urandom) if is_caller else RelayTransport.wait_at(relay, PLATE)
    peer, other = transport.remote, (OUTSIDE[role], PORT)
    with transport, UdpSocket.bind("0.0.0.0", PORT) as direct:
        delays: dict[str, list[float]] = {"relay": [], "direct": []}
        sent, first = 0, time.monotonic() + WARM_UP_S
        due, end = time.monotonic(), first + seconds
        while (now := time.monotonic()) < end + 1:
            if now >= due and now < end:
                due += 1 / RATE
                sent += now >= first
                direct.send([(STAMP.pack(time.monotonic()).ljust(SIZE), other)])
                if peer:
                    transport.send([(STAMP.pack(time.monotonic()).ljust(SIZE), peer)])
            for name, datagrams in (("direct", direct.receive()), ("relay", transport.receive(100))):
                for data, address, _ in datagrams:
                    peer = peer or (address if name == "relay" else None)
                    (stamp,) = STAMP.unpack_from(data)
                    if first <= stamp:
                        delays[name].append(time.monotonic() - stamp)
            handles: list[HasFileno] = [*transport.handles, *direct.handles]
            select.select(handles, [], [], max(0.0, min(due, end) - time.monotonic()))
    print(json.dumps({"sent": sent, **delays}), flush=True)


def measure(seconds: float) -> Delays:
    """Return the delays of both ways."""
    build("cone")
    relay = start_relay()
    try:
        time.sleep(3)
        ends = [
            start(space, str(Path(__file__)), "--probe", role, "--seconds", str(seconds))
            for space, role in (("a", "wait"), ("b", "call"))
        ]
        results = [EndDelays(**json.loads(end.communicate()[0].splitlines()[-1])) for end in ends]
    finally:
        relay.terminate()
        relay.wait()
        tear_down()
    return summarize(results)


def summarize(results: list[EndDelays]) -> Delays:
    """Return the figures of both ends."""
    sent = sum(result.sent for result in results)
    relay, direct = (
        sorted(delay * 1000 for result in results for delay in getattr(result, name)) for name in ("relay", "direct")
    )
    relay_p95, direct_p95 = (delays[len(delays) * 95 // 100] for delays in (relay, direct))
    return Delays(
        relay_p50_ms=statistics.median(relay),
        relay_p95_ms=relay_p95,
        direct_p50_ms=statistics.median(direct),
        direct_p95_ms=direct_p95,
        added_p95_ms=relay_p95 - direct_p95,
        relay_loss=1 - len(relay) / sent,
        direct_loss=1 - len(direct) / sent,
        reaches=relay_p95 - direct_p95 <= MAX_ADDED_MS,
    )


def main() -> None:
    """Measure, or be one end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--probe", choices=["wait", "call"], help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.probe:
        probe(options.probe, options.seconds)
        return
    delays = measure(options.seconds)
    if options.json:
        print(json.dumps(asdict(delays)))
    else:
        print("\n".join(f"{name:14} {value}" for name, value in asdict(delays).items()))
    sys.exit(not delays.reaches)


if __name__ == "__main__":
    main()
