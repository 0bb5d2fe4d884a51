"""Measure a call while a third party floods the receiver with junk datagrams.

    python tools/bench/flood.py [--rate 50000] [--seconds 10] [--json]

Two calls on loopback, each between two processes (tools/bench/call_probe.py): `peace` without a flood, `flood` with
--rate junk datagrams a second (random bytes, damaged headers of a session, damaged hellos) sent to the receiver from a
third process. Prints for each: frames sent and received, images drawn a second, the longest stall, and the rate of the
flood that was sent and read.
"""

import argparse
import json
import multiprocessing
import random
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.protocol.session.packet import Kind, handshake_datagram
from tools.bench.call_probe import read_lines, split_address, start, start_receiver
from tools.bench.carphone import fetch_carphone

CODE = "amber-canoe-tiger-7"
SETTLE_S = 3.0
SLICES = 100  # bursts a second
Lines = list[dict[str, Any]]


def junk(count: int) -> list[bytes]:
    """Return junk datagrams of every kind in turn."""
    rng = random.Random(1)
    hello = handshake_datagram(Kind.HELLO, bytes(8), bytes(8), bytes(32))
    makers = (
        lambda: rng.randbytes(60),
        lambda: bytes((0x94, 2, rng.randrange(128), rng.randrange(128), 0xC4, 20)) + rng.randbytes(20),
        lambda: hello[:-1] + rng.randbytes(1),
        lambda: handshake_datagram(Kind.HELLO, rng.randbytes(8), bytes(8), bytes(32)),
    )
    return [makers[i % len(makers)]() for i in range(count)]


def flood(address: tuple[str, int], rate: int, seconds: float, sent: Any) -> None:
    """Send junk to an address and keep `sent` at the number of datagrams."""
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    datagrams, count, began = junk(rate // SLICES), 0, time.monotonic()
    while (now := time.monotonic()) < began + seconds:
        for data in datagrams:
            udp.sendto(data, address)
        count += len(datagrams)
        sent.value = count
        time.sleep(max(0.0, began + count / rate - now))


def call(rate: int, seconds: float) -> dict[str, Any]:
    """Make a call, flood it, and return its figures during the flood."""
    receiver, address = start_receiver(CODE, seconds + 60)
    sender = start("send", address, CODE, seconds + 60, fetch_carphone())
    received: Lines = []
    sent: Lines = []
    assert sender.stdout is not None and receiver.stdout is not None
    threads = [
        threading.Thread(target=read_lines, args=(sender.stdout, sent)),
        threading.Thread(target=read_lines, args=(receiver.stdout, received)),
    ]
    junk_count = multiprocessing.Value("q", 0)
    try:
        for thread in threads:
            thread.start()
        limit = time.monotonic() + 60
        while not (received and received[-1]["frames_received"] > 20) and time.monotonic() < limit:
            time.sleep(0.2)
        time.sleep(SETTLE_S)
        begin = time.monotonic()
        attacker = multiprocessing.Process(target=flood, args=(split_address(address), rate, seconds, junk_count))
        if rate:
            attacker.start()
            attacker.join()
        else:
            time.sleep(seconds)
        end = time.monotonic()
    finally:
        for process in (sender, receiver):
            process.kill()
        for thread in threads:
            thread.join()
        for process in (sender, receiver):
            process.communicate()
    return figures(sent, received, (begin, end), junk_count.value)


def figures(sent: Lines, received: Lines, span: tuple[float, float], junk_count: int) -> dict[str, Any]:
    """Return the figures of the span (begin, end), s on the monotonic clock."""
    receiver = [line for line in received if span[0] <= line["at"] <= span[1] + 1] or received[-1:]
    sender = [line for line in sent if span[0] <= line["at"] <= span[1] + 1] or sent[-1:]
    images = [image for line in received for image in line["pictures"] if span[0] <= image[0] <= span[1]]
    seconds = span[1] - span[0]
    return {
        "junk_per_s": round(junk_count / seconds),
        "junk_read_per_s": round((receiver[-1]["rejected"] - receiver[0]["rejected"]) / seconds),
        "frames_sent_per_s": round((sender[-1]["frames_sent"] - sender[0]["frames_sent"]) / seconds, 1),
        "frames_received_per_s": round((receiver[-1]["frames_received"] - receiver[0]["frames_received"]) / seconds, 1),
        "pictures_per_s": round(len(images) / seconds, 1),
        "longest_stall_s": round(max((image[2] for image in images), default=seconds), 2),
        "receiver_kb": receiver[-1]["memory_kb"],
    }


def main() -> None:
    """Make both calls and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=int, default=50_000)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    result = {"peace": call(0, options.seconds), "flood": call(options.rate, options.seconds)}
    if options.json:
        print(json.dumps(result))
        return
    for name in result["peace"]:
        print(f"{name:24} {result['peace'][name]:>10} {result['flood'][name]:>10}")


if __name__ == "__main__":
    main()
