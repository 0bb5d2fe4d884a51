"""Measure the time of the session layer: sealing, opening, junk of each kind, a handshake.

    python tools/bench/session.py [--json] [--fuzz N]

Median and fastest of 15 runs. `--fuzz N` then sends N mutated and random datagrams to both ends of a live session and
checks that only the counters of dropped datagrams change.
"""

import argparse
import json
import os
import random
import sys
import time
import tracemalloc
from collections.abc import Callable
from statistics import median

from conf.protocol.session.client import SenderSession
from conf.protocol.session.handshake import receiver_secrets, sender_share
from conf.protocol.session.packet import VERSION, Kind, handshake_datagram
from conf.protocol.session.server import SessionServer

CODE = "acorn-tulip-river-42"
SENDER, RECEIVER = ("198.51.100.7", 40000), ("192.0.2.1", 5005)
RUNS = 15


def connect() -> tuple[SenderSession, SessionServer, list[bytes]]:
    """Return both ends of a session, and the datagrams of its handshake."""
    receiver = SessionServer(CODE, os.urandom)
    sender = SenderSession(CODE, RECEIVER, os.urandom, 0.0)
    datagrams = []
    while sender.session is None:
        for data, _ in sender.datagrams_to_send(0.0):
            datagrams.append(data)
            receiver.receive_datagram(data, SENDER, 0.0)
        for data, _ in receiver.datagrams_to_send(0.0):
            datagrams.append(data)
            sender.receive_datagram(data, RECEIVER, 0.0)
    drain(receiver)
    drain(sender)
    return sender, receiver, datagrams


def drain(side: SenderSession | SessionServer) -> int:
    """Discard all events and return their number."""
    count = 0
    while side.next_event() is not None:
        count += 1
    return count


def microseconds(work: Callable[[], object], times: int) -> dict[str, float]:
    """Return the median and the fastest time of one call, over RUNS runs of so many calls."""
    results = []
    for _ in range(RUNS):
        start = time.perf_counter()
        for _ in range(times):
            work()
        results.append((time.perf_counter() - start) / times * 1e6)
    return {"median_us": round(median(results), 2), "fastest_us": round(min(results), 2)}


def measure() -> dict[str, dict[str, float]]:
    """Return the time of each case."""
    sender, receiver, _ = connect()
    session = sender.session
    assert session is not None
    rng = random.Random(1)

    def junk(data: bytes) -> Callable[[], None]:
        return lambda: receiver.receive_datagram(data, ("203.0.113.9", 1), 1.0)

    def body() -> None:
        sealed = sender.seal_body(b"motion")
        assert sealed is not None
        sender.acknowledge(sealed.counter)
        receiver.receive_datagram(sealed.datagram, SENDER, 1.0)
        receiver.next_event()

    def seal_only() -> None:
        sealed = sender.seal_body(b"motion")
        assert sealed is not None
        sender.acknowledge(sealed.counter)

    head = bytes((0x94, VERSION, session, 5, 0xC4, 40))
    long_head = bytes((0x94, VERSION, session, 5, 0xC5)) + (1190).to_bytes(2)
    unknown = bytes((0x94, VERSION, session ^ 1, 5, 0xC4, 40))
    hello = handshake_datagram(Kind.HELLO, bytes(8), bytes(8), bytes(32))
    confirm = handshake_datagram(Kind.CONFIRM, bytes(8), 0, bytes(16))
    key_share = sender_share(CODE, os.urandom)[1]
    first_byte_only = bytes((0x94,)) + rng.randbytes(45)
    fifty = microseconds(fifty_hellos(hello), 1)
    return {
        "seal": microseconds(seal_only, 2000),
        "seal_and_open": microseconds(body, 2000),
        "junk_random": microseconds(junk(rng.randbytes(46)), 5000),
        "junk_empty": microseconds(junk(b""), 5000),
        "junk_right_first_byte": microseconds(junk(first_byte_only), 5000),
        "junk_data_of_live_session": microseconds(junk(head + rng.randbytes(40)), 5000),
        "junk_data_of_live_session_1197_B": microseconds(junk(long_head + rng.randbytes(1190)), 2000),
        "junk_data_of_unknown_session": microseconds(junk(unknown + rng.randbytes(40)), 5000),
        "junk_hello": microseconds(junk(hello), 5000),
        "junk_hello_damaged": microseconds(junk(hello[:-1] + b"x"), 5000),
        "junk_confirm": microseconds(junk(confirm), 5000),
        "hello_answered_with_cookie": {name: round(us / 50, 2) for name, us in fifty.items()},
        "curve_work_sender_start": microseconds(lambda: sender_share(CODE, os.urandom), 5),
        "curve_work_receiver": microseconds(lambda: receiver_secrets(CODE, bytes(8), key_share, os.urandom), 5),
    }


def fifty_hellos(hello: bytes) -> Callable[[], None]:
    """Return a function that sends a new receiver fifty hellos, each of which it answers with a cookie."""

    def work() -> None:
        receiver = receivers.pop()
        for port in range(50):
            receiver.receive_datagram(hello, ("203.0.113.9", port), 0.0)

    receivers = [SessionServer(CODE, os.urandom) for _ in range(RUNS)]
    return work


def fuzz(count: int) -> dict[str, float]:
    """Send `count` datagrams, half of them random, half mutated, to both ends of a live session."""
    sender, receiver, datagrams = connect()
    for _ in range(100):
        sealed = sender.seal_body(os.urandom(random.randrange(40)))
        assert sealed is not None
        datagrams.append(sealed.datagram)
        receiver.receive_datagram(sealed.datagram, SENDER, 0.0)
    drain(receiver)
    originals, rng = set(datagrams), random.Random(2)
    sessions = {number: vars(peer.opening_key.window).copy() for number, peer in receiver.sessions.items()}
    tracemalloc.start()
    before, done, start = tracemalloc.get_traced_memory()[0], 0, time.perf_counter()
    while done < count:
        data = mutate(rng.choice(datagrams), rng) if done % 2 else rng.randbytes(rng.randrange(80))
        if data in originals:
            continue
        done += 1
        receiver.receive_datagram(data, SENDER, 0.0)
        sender.receive_datagram(data, RECEIVER, 0.0)
        if sum(len(answer) for answer, _ in receiver.datagrams_to_send(0.0)) > len(data):
            sys.exit(f"the answer is larger than the datagram {data.hex()}")
        if drain(receiver) or drain(sender):
            sys.exit(f"the datagram caused an event: {data.hex()}")
    seconds, growth = time.perf_counter() - start, tracemalloc.get_traced_memory()[0] - before
    if sessions != {number: vars(peer.opening_key.window) for number, peer in receiver.sessions.items()}:
        sys.exit("the state of a session has changed")
    dropped = {str(reason): number for reason, number in sorted(receiver.dropped.items())}
    return {"datagrams": done, "seconds": round(seconds, 1), "memory_growth_bytes": growth, **dropped}


def mutate(data: bytes, rng: random.Random) -> bytes:
    """Return a datagram with up to three bits flipped, in some cases truncated or extended."""
    result = bytearray(data)
    for _ in range(rng.randint(0, 3)):
        bit = rng.randrange(8 * len(result))
        result[bit // 8] ^= 1 << bit % 8
    if rng.random() < 0.3:
        del result[rng.randrange(len(result)) :]
    if rng.random() < 0.2:
        result += rng.randbytes(rng.randrange(1, 5))
    return bytes(result)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    parser.add_argument("--fuzz", type=int, default=0, metavar="N", help="send N bad datagrams to a live session")
    options = parser.parse_args()
    costs = measure()
    result: dict[str, object] = {"handshake_bytes": [len(data) for data in connect()[2]], **costs}
    if options.fuzz:
        result["fuzz"] = fuzz(options.fuzz)
    if options.json:
        print(json.dumps(result))
        return
    for name, value in costs.items():
        print(f"{name:36} {value['median_us']:9.2f} us median {value['fastest_us']:9.2f} us fastest")
    print("handshake, bytes a datagram:", result["handshake_bytes"])
    if options.fuzz:
        print("fuzz:", result["fuzz"])


if __name__ == "__main__":
    main()
