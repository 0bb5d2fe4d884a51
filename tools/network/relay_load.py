"""Load and attack a relay, in a network of its own.

    python tools/network/relay_load.py load [--calls 250] [--rate 15] [--seconds 20] [--json]
    python tools/network/relay_load.py hostile [--messages 1000000] [--json]

load: calls of two over one `conf relay`, each end sending datagrams of 50 B at a rate. Reported are loss and delay, and
the processor time of the relay beside that of one message as measured for the design (47,000 a second a core).
Both ends of all calls run in processes of their own on the same machine: measure on a quiet one.

hostile: while two calls go on, messages of strangers. A third are junk at the relay's UDP port, a third STUN requests
and junk at the STUN ports, a third datagrams through the relay to the waiting end of one call, half of them over TCP
from ever new names. Reported are the loss of that call and of the other, what was counted, and the memory of the relay
and of the waiting end.
"""

import argparse
import json
import multiprocessing
import os
import random
import resource
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Barrier, Event
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import zenoh

from conf.protocol.address import RelayAddress
from conf.transport.relay_settings import KEY_PREFIX, client_settings, open_zenoh
from conf.transport.stun import encode_request
from conf.transport.zenoh_transport import MAX_QUEUED, RelayTransport
from tools.network.own_network import enter_own_network

HOST, PORT = "127.0.0.1", 7447
RELAY = (HOST, PORT)
SIZE = 50
WARM_UP_S = 2.0
READY_S = 300.0
ATTEMPTS = 10
MESSAGES_PER_CORE = 47_000  # a second, forwarded by zenoh's router, as measured for the design
DRIVERS = 2
FILES = 16_384
BURST = 100
SLOW_BURST = 4  # each millisecond; faster, zenoh would drop most of them at the sender
NAMES = "abcdefghijklmnopqrstuvwxyz"
COUNTED = ("forwarded", "strangers", "excess", "overflows", "stun_answered", "stun_ignored")
MAX_GROWTH_MB = 64.0


Result = tuple[int, list[float]]  # datagrams sent, delays of those received, s


@dataclass(frozen=True)
class Load:
    """sent, received : datagrams; overflows : dropped by the kernel from full receive buffers, with the warm-up

    cpu : of the relay, cores; arithmetic : what the design expects, cores
    """

    calls: int
    sent: int
    received: int
    overflows: int
    loss: float
    p50_ms: float
    p95_ms: float
    cpu: float
    arithmetic: float
    relay_mb: float


@dataclass(frozen=True)
class Attack:
    """sent : hostile messages by way; loss : of the call that is attacked; other_loss : of the other

    read : hostile datagrams that the waiting end had to look at; dropped : those it has dropped unread
    counts : what the relay has counted; kernel : datagrams dropped by the system from full buffers of any socket
    uncounted : hostile messages over UDP, less what the relay has counted; below 0 by what the calls have sent
    sessions : that the waiting end has opened; 1 if it has never lost the relay
    relay_mb, waiter_mb : memory before and after
    """

    sent: dict[str, int]
    seconds: float
    loss: float
    other_loss: float
    dropped: int
    read: int
    counts: dict[str, int]
    kernel: int
    uncounted: int
    sessions: int
    relay_cpu: float
    relay_mb: tuple[float, float]
    waiter_mb: tuple[float, float]


def memory_mb(process: int) -> float:
    """Return the resident memory of a process."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def cpu_s(process: int) -> float:
    """Return the processor time of a process, all threads."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def udp_overflows() -> int:
    """Return how many datagrams this network has dropped as the receive buffer of a socket was full."""
    names, values = (
        line.split() for line in Path("/proc/net/snmp").read_text().splitlines() if line.startswith("Udp:")
    )
    return int(values[names.index("RcvbufErrors")])


@contextmanager
def running_relay() -> Iterator[subprocess.Popen[str]]:
    """Run `conf relay`; its figures can be read from stdout after a SIGINT."""
    command = [sys.executable, "-m", "conf", "relay", "--listen", f"{HOST}:{PORT}", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        process.stderr.readline()
        try:
            yield process
        finally:
            process.kill()


def drive(first: int, calls: int, options: argparse.Namespace, ready: "Barrier", results: "Queue[Result]") -> None:
    """Hold calls in this process. Puts how many datagrams were sent, and the delays of those received, s.

    Bare sessions with the settings of a call: the threads that watch those of a program would be most of the load.
    """
    delays: list[float] = []

    def on_sample(sample: zenoh.Sample) -> None:
        data = sample.payload.to_bytes()
        if data[17:18] == b"1":
            delays.append(time.monotonic() - float(data[:17]))

    publishers, sessions = [], []
    for number in range(calls):
        key = f"{KEY_PREFIX}/{first + number}"
        for own, other in (("to", "from"), ("from", "to")):
            sessions.append(open_patiently())
            sessions[-1].declare_subscriber(f"{key}/{own}/a", on_sample)
            publishers.append(
                sessions[-1].declare_publisher(
                    f"{key}/{other}/a",
                    reliability=zenoh.Reliability.BEST_EFFORT,
                    congestion_control=zenoh.CongestionControl.DROP,
                    express=False,
                )
            )
    random.Random(first).shuffle(publishers)
    sent = index = 0
    ready.wait(READY_S)
    start = time.monotonic()
    first_counted = start + WARM_UP_S
    end = first_counted + options.seconds
    interval = 1 / (options.rate * len(publishers))
    while (now := time.monotonic()) < end:
        while start + index * interval <= now:
            is_counted = now >= first_counted
            publishers[index % len(publishers)].put((b"%17.6f%d" % (now, is_counted)).ljust(SIZE))
            sent += is_counted
            index += 1
        time.sleep(0.002)
    time.sleep(1)
    results.put((sent, delays))
    results.close()
    results.join_thread()
    os._exit(0)  # without closing hundreds of sessions one by one


def open_patiently() -> zenoh.Session:
    """Return a session with the relay; on a busy machine that may need several attempts."""
    for _ in range(ATTEMPTS):
        with suppress(zenoh.ZError):
            return open_zenoh(client_settings(RELAY))
    raise TimeoutError("the relay does not answer")


def measure_load(options: argparse.Namespace) -> Load:
    """Hold many calls."""
    context = multiprocessing.get_context("spawn")
    results: Queue[Result] = context.Queue()
    with running_relay() as relay:
        ready = context.Barrier(DRIVERS + 1)
        part = options.calls // DRIVERS
        arguments = [(1000 + number * part, part, options, ready, results) for number in range(DRIVERS)]
        processes = [context.Process(target=drive, args=item, daemon=True) for item in arguments]
        for process in processes:
            process.start()
        ready.wait(READY_S)
        time.sleep(WARM_UP_S)
        before, began = cpu_s(relay.pid), time.monotonic()
        time.sleep(options.seconds)
        cpu = (cpu_s(relay.pid) - before) / (time.monotonic() - began)
        found = [results.get(timeout=60) for _ in processes]
        memory = memory_mb(relay.pid)
    sent = sum(number for number, _ in found)
    delays = sorted(delay for _, found_delays in found for delay in found_delays)
    return Load(
        calls=DRIVERS * part,
        sent=sent,
        received=len(delays),
        overflows=udp_overflows(),
        loss=1 - len(delays) / sent,
        p50_ms=delays[len(delays) // 2] * 1000,
        p95_ms=delays[len(delays) * 95 // 100] * 1000,
        cpu=cpu,
        arithmetic=2 * DRIVERS * part * options.rate / MESSAGES_PER_CORE,
        relay_mb=memory,
    )


def flood_udp(count: int, ports: list[int], seed: int) -> int:
    """Send junk and STUN requests to ports of the relay. Returns how many were sent."""
    generator = random.Random(seed)
    junk = [generator.randbytes(generator.randrange(1, 1400)) for _ in range(500)]
    junk += [encode_request(generator.randbytes(12)) for _ in range(500)] if len(ports) > 1 else []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as handle:
        for number in range(count):
            handle.sendto(junk[number % len(junk)], (HOST, ports[number % len(ports)]))
            if number % BURST == 0:
                select.select([], [], [], 0.002)
    return count


def flood_relay(count: int, plate: str, seed: int, kind: str) -> int:
    """Send junk through the relay to the waiting end. Returns how many were sent.

    kind : "tcp", from ever new names, or "udp", from one, each in a datagram of its own: only a declared key goes there
    """
    generator = random.Random(seed)
    junk = [generator.randbytes(generator.choice((0, 1, 50, 1400, 3000))) for _ in range(500)]
    session = open_zenoh(client_settings(RELAY))
    key, drop = f"{KEY_PREFIX}/{plate}/to", zenoh.CongestionControl.DROP
    publisher = session.declare_publisher(
        f"{key}/junk", reliability=zenoh.Reliability.BEST_EFFORT, congestion_control=drop, express=True
    )
    for number in range(count):
        data = junk[number % len(junk)]
        if kind == "udp":
            publisher.put(data)
        else:
            session.put(f"{key}/{''.join(generator.choices(NAMES, k=8))}", data, congestion_control=drop)
        if number % (SLOW_BURST if kind == "udp" else BURST) == 0:
            time.sleep(0.001)
    with suppress(zenoh.ZError):  # the relay lets it wait
        session.close()
    return count


def count_sessions(transport: RelayTransport) -> list[zenoh.Session]:
    """Return a list to which each session is added that a transport opens from now on."""
    sessions: list[zenoh.Session] = []
    on_open = transport._link._on_open

    def count(session: zenoh.Session) -> None:
        sessions.append(session)
        on_open(session)

    transport._link._on_open = count
    return sessions


def hold_other_call(ready: "Barrier", is_over: "Event", results: "Queue[Result]") -> None:
    """Hold the call that nobody attacks. Puts how many datagrams were sent, and the delays of those received, s."""
    with RelayTransport.wait_at(RELAY, "4712") as waiter, RelayTransport.call(RELAY, "4712", os.urandom) as caller:
        delays: list[float] = []
        for _ in range(20):
            caller.send([(b"%17.6f" % 0, waiter.address)])
            waiter.wait(0.1)
            waiter.receive(MAX_QUEUED)
        ready.wait(READY_S)
        sent, due = 0, 0.0
        while not is_over.is_set():
            now = time.monotonic()
            if now >= due:
                due = now + 1 / 15
                caller.send([((b"%17.6f" % now).ljust(SIZE), waiter.address)])
                sent += 1
            waiter.wait(0.02)
            delays += [time.monotonic() - float(data[:17]) for data, _, _ in waiter.receive(MAX_QUEUED)]
        time.sleep(1)
        delays += [time.monotonic() - float(data[:17]) for data, _, _ in waiter.receive(MAX_QUEUED)]
        results.put((sent, delays))


def measure_attack(options: argparse.Namespace) -> Attack:
    """Attack the relay and one call."""
    third = options.messages // 3
    context = multiprocessing.get_context("spawn")
    with running_relay() as relay:
        waiter, caller = RelayTransport.wait_at(RELAY, "4711"), RelayTransport.call(RELAY, "4711", os.urandom)
        while not (waiter.is_open and caller.is_open):
            time.sleep(0.05)
        sessions = count_sessions(waiter)
        results: Queue[Result] = context.Queue()
        ready, is_over = context.Barrier(2), context.Event()
        other = context.Process(target=hold_other_call, args=(ready, is_over, results), daemon=True)
        other.start()
        ready.wait(READY_S)
        relay_before, waiter_before = memory_mb(relay.pid), memory_mb(os.getpid())
        with context.Pool(4) as pool:
            tasks = {
                "relay": pool.apply_async(flood_udp, (third, [PORT], 1)),
                "stun": pool.apply_async(flood_udp, (third, [PORT + 1, PORT + 2], 2)),
                "through_udp": pool.apply_async(flood_relay, (third // 2, "4711", 3, "udp")),
                "through_tcp": pool.apply_async(flood_relay, (third - third // 2, "4711", 4, "tcp")),
            }
            began, sent, received, read, due = time.monotonic(), 0, 0, 0, 0.0
            while not all(task.ready() for task in tasks.values()) or due < 1:
                now = time.monotonic()
                if now >= due:
                    due = now + 1 / 15
                    caller.send([(b"call".ljust(SIZE), RelayAddress("4711", ""))])
                    sent += 1
                for data, address, _ in waiter.receive(MAX_QUEUED):
                    is_call = data.startswith(b"call")
                    received += is_call
                    read += not is_call
                    waiter.send([(b"r" * SIZE, address)])  # as a handshake would
                caller.receive(MAX_QUEUED)
                waiter.wait(0.005)
            numbers = {name: task.get() for name, task in tasks.items()}
        seconds = time.monotonic() - began
        is_over.set()
        other_sent, other_delays = results.get(timeout=60)
        relay_cpu = cpu_s(relay.pid) / seconds
        time.sleep(1)
        received += sum(data.startswith(b"call") for data, _, _ in waiter.receive(MAX_QUEUED * 10))
        after = memory_mb(relay.pid), memory_mb(os.getpid())
        relay.send_signal(signal.SIGINT)
        assert relay.stdout
        figures = json.loads(relay.stdout.read())
        counts = {name: figures[name] for name in (*COUNTED, "refused", "tcp_bytes", "tcp_pauses")}
        dropped = waiter.dropped
        caller.close()
        waiter.close()
    return Attack(
        sent=numbers,
        seconds=seconds,
        loss=1 - received / sent,
        other_loss=1 - len(other_delays) / other_sent,
        dropped=dropped,
        read=read,
        counts=counts,
        kernel=udp_overflows(),
        uncounted=sum(numbers.values()) - numbers["through_tcp"] - sum(counts[name] for name in COUNTED),
        sessions=len(sessions) + 1,
        relay_cpu=relay_cpu,
        relay_mb=(relay_before, after[0]),
        waiter_mb=(waiter_before, after[1]),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["load", "hostile"])
    parser.add_argument("--calls", type=int, default=250)
    parser.add_argument("--rate", type=float, default=15.0)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    enter_own_network()
    resource.setrlimit(resource.RLIMIT_NOFILE, (FILES, FILES))
    if options.what == "load":
        result: Load | Attack = measure_load(options)
        reaches = result.received == result.sent  # type: ignore[union-attr]
    else:
        result = measure_attack(options)
        reaches = max(after - before for before, after in (result.relay_mb, result.waiter_mb)) <= MAX_GROWTH_MB
    # Of an attack only the memory is judged: what it does to the call, and what nobody counts, is for the reader.
    values = asdict(result) | {"reaches" if options.what == "load" else "memory_bounded": reaches}
    print(json.dumps(values) if options.json else "\n".join(f"{name:14} {value}" for name, value in values.items()))
    sys.exit(not reaches)


if __name__ == "__main__":
    main()
