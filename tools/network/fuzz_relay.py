"""Send hostile bytes to all ports of a relay while a call goes on over it, in a network of its own.

    python tools/network/fuzz_relay.py [--datagrams 1000000] [--seed 1] [--json]

Half go to the UDP ports, those of STUN included: messages that open a session, and STUN requests, whole, mutated,
truncated and longer than any. The others go over TCP, on up to 60 connections at a time: the same, and connections that
send one byte a second or a part of a message and nothing more. The program ends with an error when the relay has ended,
or when its memory grows.
"""

import json
import multiprocessing
import os
import random
import signal
import socket
import sys
import time
from contextlib import suppress
from multiprocessing.queues import Queue
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.relay.udp_front import LENGTH
from conf.transport.relay_settings import client_settings, open_zenoh
from conf.transport.stun import encode_request
from tools.bench.session import mutate
from tools.network.fuzzer import run_fuzzer
from tools.network.own_network import enter_own_network
from tools.network.relay_load import (
    HOST,
    MAX_GROWTH_MB,
    PORT,
    READY_S,
    Result,
    hold_other_call,
    memory_mb,
    running_relay,
)

MAX_CONNECTIONS = 60
MAX_UDP = 65_000
HOSTS = 100  # sources, 127.0.1.x
SLOW_S = 1.0  # between bytes of a slow connection
BURST = 50  # messages, then a rest of 2 ms
MUST_ARRIVE = 0.98  # of the call's datagrams


def record_opening() -> bytes:
    """Return the first message of a member over TCP, with its length in front."""
    with socket.create_server((HOST, 0)) as listener:
        listener.settimeout(5)
        settings = dict(client_settings((HOST, PORT)))
        settings["connect/endpoints"] = [f"tcp/{HOST}:{listener.getsockname()[1]}?rel=1"]
        process = multiprocessing.get_context("fork").Process(target=_open_and_fail, args=(settings,), daemon=True)
        process.start()
        with listener.accept()[0] as connection:
            data = connection.recv(4096)
        process.join(10)
        return data


def _open_and_fail(settings: dict[str, object]) -> None:
    with suppress(Exception):
        open_zenoh(settings)
    os._exit(0)


class HostileMessages:
    """Messages of strangers. opening : a whole message over TCP that opens a session"""

    def __init__(self, opening: bytes, seed: int) -> None:
        self._random = random.Random(seed)
        self._opening = opening

    def over_udp(self) -> bytes:
        """Return a datagram for the relay's port."""
        return self._damaged(self._opening[LENGTH.size :], MAX_UDP)

    def to_stun(self) -> bytes:
        """Return a datagram for a STUN port."""
        return self._damaged(encode_request(self._random.randbytes(12)), MAX_UDP)

    def over_tcp(self) -> bytes:
        """Return what a connection sends."""
        return self._damaged(self._opening, 200_000)

    def _damaged(self, data: bytes, limit: int) -> bytes:
        kind = self._random.randrange(20)
        if kind == 0:
            return data + self._random.randbytes(self._random.randrange(limit - len(data)))
        if kind < 4:
            return self._random.randbytes(self._random.randrange(1, 1400))
        if kind < 8:
            return data[: self._random.randrange(1, len(data))]
        return data if kind < 10 else mutate(data, self._random)


class HostileConnections:
    """Connections to the relay's TCP port. sent : messages; closed : connections that the relay has closed"""

    def __init__(self, messages: HostileMessages, seed: int) -> None:
        self.sent = self.closed = 0
        self._messages = messages
        self._random = random.Random(seed)
        self._open: list[socket.socket] = []
        self._slow: dict[socket.socket, tuple[bytes, float]] = {}

    def step(self, now: float) -> None:
        """Open a connection and send, and let one of the others go on."""
        self.sent += 1
        if len(self._open) >= MAX_CONNECTIONS:
            self._open.pop(self._random.randrange(len(self._open))).close()
        handle = socket.socket()
        handle.settimeout(1)
        try:
            handle.bind((f"127.0.1.{self._random.randrange(HOSTS) + 1}", 0))
            handle.connect((HOST, PORT))
            handle.setblocking(False)
            if self._random.random() < 0.05:
                self._slow[handle] = self._messages.over_tcp(), now
            else:
                handle.send(self._messages.over_tcp())
            self._open.append(handle)
        except OSError:
            self.closed += 1
            handle.close()
        self._slow = {h: item for h, item in self._slow.items() if h.fileno() >= 0 and item[0]}
        for slow, (rest, due) in self._slow.items():
            if now >= due:
                self._slow[slow] = rest[1:], now + SLOW_S
                with suppress(OSError):
                    slow.send(rest[:1])

    def close(self) -> None:
        """Close all."""
        for handle in self._open:
            handle.close()


def fuzz(count: int, seed: int) -> dict[str, Any]:
    """Attack a relay. Raises AssertionError if it does not withstand."""
    context = multiprocessing.get_context("spawn")
    opening = record_opening()
    with running_relay() as relay:
        results: Queue[Result] = context.Queue()
        ready, is_over = context.Barrier(2), context.Event()
        context.Process(target=hold_other_call, args=(ready, is_over, results), daemon=True).start()
        ready.wait(READY_S)
        messages = HostileMessages(opening, seed)
        connections = HostileConnections(messages, seed)
        sources = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(HOSTS)]
        for number, source in enumerate(sources):
            source.bind((f"127.0.1.{number + 1}", 0))
        before, began = memory_mb(relay.pid), time.monotonic()
        for number in range(count):
            source = sources[number // 4 % HOSTS]
            match number % 4:
                case 0:
                    source.sendto(messages.over_udp(), (HOST, PORT))
                case 1:
                    source.sendto(messages.to_stun(), (HOST, PORT + 1 + number // 4 % 2))
                case _:
                    connections.step(time.monotonic())
            if number % BURST == 0:
                time.sleep(0.002)
        seconds = time.monotonic() - began
        is_over.set()
        sent, delays = results.get(timeout=60)
        connections.close()
        after = memory_mb(relay.pid)
        assert relay.poll() is None, "the relay has ended"
        relay.send_signal(signal.SIGINT)
        assert relay.stdout
        counts = json.loads(relay.stdout.read())
    assert after - before <= MAX_GROWTH_MB, f"memory grew from {before:.0f} to {after:.0f} MB"
    assert len(delays) >= MUST_ARRIVE * sent, f"{len(delays)} of {sent} datagrams of the call arrived"
    names = ("strangers", "excess", "overflows", "refused", "stun_answered", "stun_ignored", "max_members")
    return {
        "seconds": round(seconds, 1),
        "tcp_messages": connections.sent,
        "tcp_not_connected": connections.closed,
        "call_sent": sent,
        "call_received": len(delays),
        "memory_mb": [round(before, 1), round(after, 1)],
        **{name: counts[name] for name in names},
    }


if __name__ == "__main__":
    enter_own_network()
    run_fuzzer(fuzz, __doc__)
