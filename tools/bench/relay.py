"""Measure what a call over a relay costs on the wire, in a network of its own.

    python tools/bench/relay.py [--seconds 60] [--json]

A relay as `conf relay` runs it, and both ends of a call over it. Packets are captured, and counted with their IPv4
headers: first datagrams of 50 B at 20 a second each way, then the talkers of two_way_call.py with the profile `live`
for the whole time, with everything that passes between an end and the relay: datagrams, keep-alives, acknowledgements.
The capture is searched for the names and states that both ends send: it must hold none.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import MotionFrame
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.statistics import HEADER_BYTES
from conf.transport.exchange import DatagramExchange
from conf.transport.zenoh_transport import RelayTransport
from tools.bench.tracks import Track, TrackReader
from tools.bench.two_way_call import PARAMETERS, PROFILE_FPS, TALKERS
from tools.bench.voice import SHARED
from tools.bench.voice_link import CODE
from tools.network.own_network import Capture, enter_own_network

RELAY = ("127.0.0.1", 7447)
PLATE = "4711"
NAMES = ("Adaliciousname", "Bobaliciousname")
PAYLOAD = 50
WARM_UP = 20
MAX_MORE_B = 6
MAX_KBPS = 6.6


@dataclass(frozen=True)
class RelayCost:
    """more_b : bytes a datagram more than over UDP, on each of the four legs
    kbps : of both directions, captured between the end that sends and the relay, with half of what passes over TCP
    plain_kbps : the same datagrams with UDP and IP headers alone; found : names that the capture holds in plain text
    """

    more_b: dict[str, float]
    kbps: list[float]
    plain_kbps: list[float]
    datagrams_per_s: list[float]
    found: int


def connect() -> tuple[RelayTransport, RelayTransport]:
    """Return the waiting and the calling end of a call, connected."""
    waiter, caller = RelayTransport.wait_at(RELAY, PLATE), RelayTransport.call(RELAY, PLATE, os.urandom)
    arrived = 0
    while arrived < WARM_UP:
        caller.send([(b"hello", waiter.address)])
        caller.wait(0.05)
        waiter.wait(0.05)
        for _, address, _ in waiter.receive(64):
            waiter.send([(b"hello", address)])
        arrived += len(caller.receive(64))
    return waiter, caller


def measure_datagrams(capture: Capture, waiter: RelayTransport, caller: RelayTransport) -> dict[str, float]:
    """Return the bytes that a datagram costs more than over UDP, by direction and leg."""
    result = {}
    for name, sender, receiver in (("call", caller, waiter), ("answer", waiter, caller)):
        marker, first = os.urandom(PAYLOAD), len(capture.packets)
        for _ in range(100):
            sender.send([(marker, receiver.address)])
            receiver.wait(0.05)
            receiver.receive(64)
        time.sleep(0.3)
        found = [packet for packet in capture.packets[first:] if marker in packet.payload]
        for leg, port in (("up", "destination"), ("down", "source")):
            packets = [packet for packet in found if getattr(packet, port) == RELAY[1]]
            count = sum(packet.payload.count(marker) for packet in packets)  # zenoh may join two
            result[f"{name}_{leg}"] = sum(packet.size for packet in packets) / count - PAYLOAD - HEADER_BYTES
    return result


class End:
    """One end of a call."""

    def __init__(self, transport: RelayTransport, name: str) -> None:
        self.endpoint = CallEndpoint(
            code=CODE,
            parameters=PARAMETERS,
            now=time.monotonic(),
            random=os.urandom,
            remote=transport.remote,
            rate=RateOptions("live"),
            name=name,
        )
        self.datagrams = self.bytes = 0
        self._transport = transport
        self._exchange = DatagramExchange(transport, self.endpoint)
        send = transport.send

        def count(datagrams: list[tuple[bytes, object]]) -> None:
            self.datagrams += len(datagrams)
            self.bytes += sum(len(data) + HEADER_BYTES for data, _ in datagrams)
            send(datagrams)  # type: ignore[arg-type]

        transport.send = count  # type: ignore[method-assign, assignment]

    def step(self) -> None:
        """Receive and send what is due."""
        now = time.monotonic()
        self._exchange.receive(now)
        self._exchange.send(now)
        while self.endpoint.next_event():
            pass


def hold(ends: list[End], tracks: list[Track], seconds: float, capture: Capture) -> RelayCost:
    """Hold a call, and count what passes."""
    end = time.monotonic() + 10
    while not all(item.endpoint.streams for item in ends) and time.monotonic() < end:
        for item in ends:
            item.step()
        time.sleep(0.005)
    began, first, sent = time.monotonic(), len(capture.packets), 0
    for item in ends:
        item.datagrams = item.bytes = 0
    while (now := time.monotonic() - began) < seconds:
        while sent / PROFILE_FPS <= now:
            for item, track in zip(ends, tracks, strict=True):
                frame = track.frames[sent % len(track.frames)]
                item.endpoint.send_frame(MotionFrame(sent / PROFILE_FPS, frame.displacements, frame.pose), began + now)
            sent += 1
        for item in ends:
            item.step()
        time.sleep(0.003)
    packets = capture.packets[first:]
    up = Counter[int]()
    for packet in packets:
        if packet.destination == RELAY[1] and packet.kind == "udp":
            up[packet.source] += packet.size
    tcp = sum(packet.size for packet in packets if packet.destination == RELAY[1] and packet.kind == "tcp")
    return RelayCost(
        more_b={},
        kbps=[(size + tcp / 2) * 8 / 1000 / seconds for size in up.values()],
        plain_kbps=[item.bytes * 8 / 1000 / seconds for item in ends],
        datagrams_per_s=[item.datagrams / seconds for item in ends],
        found=sum(name.encode() in packet.payload for packet in capture.packets for name in NAMES),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    enter_own_network()
    reader = TrackReader()
    tracks = [reader.read(SHARED / "motion" / f"{name}.npz", fps=PROFILE_FPS) for name in TALKERS]
    command = [sys.executable, "-m", "conf", "relay", "--listen", f"{RELAY[0]}:{RELAY[1]}", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as relay:
        assert relay.stderr
        relay.stderr.readline()
        with Capture() as capture:
            waiter, caller = connect()
            more = measure_datagrams(capture, waiter, caller)
            ends = [End(waiter, NAMES[0]), End(caller, NAMES[1])]
            cost = replace(hold(ends, tracks, options.seconds, capture), more_b=more)
            for transport in (waiter, caller):
                transport.close()
        relay.terminate()
    reaches = max(more.values()) <= MAX_MORE_B and max(cost.kbps) <= MAX_KBPS and not cost.found
    if options.json:
        print(json.dumps(asdict(cost) | {"reaches": reaches}))
    else:
        print(f"a datagram more than over UDP, B: {more}")
        print(f"live, two-way, kbit/s of both directions: {cost.kbps}; with UDP headers alone {cost.plain_kbps}")
        print(f"datagrams a second {cost.datagrams_per_s}; names in the capture {cost.found}")
        print("reaches the target" if reaches else "MISSES the target")
    sys.exit(not reaches)


if __name__ == "__main__":
    main()
