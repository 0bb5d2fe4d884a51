"""Call between two homes: two hosts behind two NATs and a relay, in network namespaces (Linux, root, iptables).

    python tools/network/nat_calls.py [--runs 20] [--case cone symmetric blocked loss cut restart deaf unheard] [--json]

The ends are CallEndpoints over the transports of `conf call`, with a face of 15 frames a second; imports do not count.
cone, symmetric: NATs whose mapping depends on nothing, or on the destination. blocked: no UDP leaves one home. loss:
every leg loses 10 %. cut: the direct path fails after 4 s. restart: the relay restarts after 4 s, with no direct path.
deaf, unheard: after 4 s, with no direct path, the router of one home (of each in turn) forgets one direction of the UDP
flow with the relay: of what comes in, or of what goes out.
Of each call: when the caller was connected, when both ends sent directly, and the longest time without a frame later.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.commands.support.relay_route import RelayRoute, call_over, wait_over
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import MotionFrame
from conf.protocol.session.events import Connected
from conf.transport.exchange import DatagramExchange
from tests.support.synthetic_motion import talking
from tests.support.two_way_call import PARAMETERS

ROOT = Path(__file__).resolve().parents[2]
PREFIX = "confnat"
SERVER = "192.0.2.1"
FPS = 15.0
LOSS = 0.1
EVENTS = ("cut", "restart", "deaf", "unheard")
SECONDS = {"cone": 4.0, "symmetric": 5.0, "blocked": 6.0, "loss": 8.0, **dict.fromkeys(EVENTS, 10.0)}
EVENT_AT_S = 4.0  # after the caller has begun
NATS = {"cone": "cone", "cut": "cone", "loss": "cone"}


def sh(command: str) -> None:
    """Run a command; raises CalledProcessError."""
    subprocess.run(command.split(), check=True, capture_output=True)


def inside(space: str, command: str) -> None:
    """Run a command in a namespace."""
    sh(f"ip netns exec {PREFIX}{space} {command}")


def tear_down() -> None:
    """Delete the namespaces."""
    for space in ("a", "b", "na", "nb", "srv", "net"):
        with suppress(subprocess.CalledProcessError):
            sh(f"ip netns del {PREFIX}{space}")


def build(case: str) -> None:
    """Make two homes, their routers, and a server on one network."""
    tear_down()
    for space in ("net", "srv", "na", "nb", "a", "b"):
        sh(f"ip netns add {PREFIX}{space}")
        inside(space, "ip link set lo up")
    inside("net", "ip link add br0 type bridge")
    inside("net", "ip link set br0 up")
    for space, address in (("srv", f"{SERVER}/24"), ("na", "192.0.2.11/24"), ("nb", "192.0.2.12/24")):
        sh(f"ip -n {PREFIX}net link add v{space} type veth peer name wan netns {PREFIX}{space}")
        inside("net", f"ip link set v{space} master br0 up")
        inside(space, f"ip addr add {address} dev wan")
        inside(space, "ip link set wan up")
    for number, home in ((1, "a"), (2, "b")):
        router = f"n{home}"
        sh(f"ip -n {PREFIX}{home} link add lan type veth peer name lan netns {PREFIX}{router}")
        for space, host in ((home, 2), (router, 1)):
            inside(space, f"ip addr add 10.{number}.0.{host}/24 dev lan")
            inside(space, "ip link set lan up")
        inside(home, f"ip route add default via 10.{number}.0.1")
        inside(router, "sysctl -qw net.ipv4.ip_forward=1")
        random_ports = "" if case in NATS else " --random-fully"
        inside(router, f"iptables -t nat -A POSTROUTING -o wan -p udp -j MASQUERADE{random_ports}")
        inside(router, "iptables -t nat -A POSTROUTING -o wan -j MASQUERADE")
        for chain in ("INPUT", "FORWARD"):  # without the first, MASQUERADE changes the port of a mapping
            inside(router, f"iptables -A {chain} -i wan -m conntrack --ctstate NEW -j DROP")
        if case == "blocked" and home == "b":
            inside(router, "iptables -I FORWARD -p udp -j DROP")
        if case == "loss":
            inside(router, f"iptables -I FORWARD -m statistic --mode random --probability {LOSS} -j DROP")


def cut() -> None:
    """Let no UDP pass between the homes; that of the relay does."""
    for router in ("na", "nb"):
        inside(router, f"iptables -I FORWARD -p udp -s {SERVER} -j ACCEPT")
        inside(router, f"iptables -I FORWARD 2 -p udp -d {SERVER} -j ACCEPT")
        inside(router, "iptables -I FORWARD 3 -p udp -j DROP")


def forget(home: str, *, is_inbound: bool) -> None:
    """Let one direction of a home's present UDP flows with the relay pass no more; new flows pass."""
    command = ["ip", "netns", "exec", f"{PREFIX}{home}", "ss", "-Hun", "state", "connected", "dst", f"{SERVER}:7447"]
    flows = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    assert flows
    for flow in flows:
        host, _, port = flow.split()[-2].rpartition(":")
        outbound = f"-s {host} --sport {port} -d {SERVER} --dport 7447"
        inbound = f"-s {SERVER} --sport 7447 -d {host} --dport {port}"
        inside(f"n{home}", f"iptables -I FORWARD -p udp {inbound if is_inbound else outbound} -j DROP")


def start(space: str, *arguments: str) -> subprocess.Popen[str]:
    """Start a Python program in a namespace."""
    command = ["ip", "netns", "exec", f"{PREFIX}{space}", sys.executable, *arguments]
    pipe = subprocess.PIPE
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=environment)


def start_relay() -> subprocess.Popen[str]:
    """Start a relay."""
    return start("srv", "-m", "conf", "relay", "--listen", f"{SERVER}:7447", "--json")


def probe(code: str, seconds: float, *, is_caller: bool) -> None:
    """Be one end of a call, and print when what happened, on the clock of the machine."""
    route = RelayRoute((SERVER, 7447))
    faces = talking(200)
    print("ready", flush=True)
    sys.stdin.readline()
    began = time.monotonic()
    transport = call_over(route, code) if is_caller else wait_over(route, code)[0]
    endpoint = CallEndpoint(
        code=code, parameters=PARAMETERS, now=time.monotonic(), random=os.urandom, remote=transport.remote
    )
    exchange = DatagramExchange(transport, endpoint, peers=lambda: endpoint.callers)
    print("waiting", flush=True)
    if not is_caller:
        sys.stdin.readline()
    result: dict[str, Any] = {"began": began, "paths": [], "sessions": 0, "frames": []}
    end, frame, received = time.monotonic() + seconds, 0, 0
    while (now := time.monotonic()) < end:
        exchange.receive(now)
        if (now - began) * FPS > frame:
            frame += 1
            face = faces[frame % len(faces)]
            endpoint.send_frame(MotionFrame(now, face.displacements, face.pose), now)
        exchange.send(now)
        result["sessions"] += sum(isinstance(event, Connected) for event in iter(endpoint.next_event, None))
        names = [transport.path_name(peer) for peer in endpoint.callers]
        if names and names[0] != (result["paths"] or [[0, ""]])[-1][1]:
            result["paths"].append([now, names[0]])
        count = sum(stream.motion.frames.count for stream in endpoint.streams.values())
        if count > received:
            received = count
            result["frames"].append(now)
        transport.wait(0.02)
    result["ended"] = now
    result["round_trip_ms"] = endpoint.status(now).round_trip_ms
    transport.close()
    print(json.dumps(result), flush=True)


def run_call(case: str, relay: subprocess.Popen[str], home: str) -> tuple[dict[str, Any], subprocess.Popen[str]]:
    """Hold one call. Returns its figures and the relay that runs now. home : whose router forgets a flow"""
    code = f"{random.randrange(1000, 10000)}-acorn-tulip-river"
    seconds = SECONDS[case]
    ends = [start(space, str(Path(__file__)), "--probe", role, "--code", code, "--seconds", str(seconds))
            for space, role in (("a", "wait"), ("b", "call"))]  # fmt: skip
    pipes = [(end.stdin, end.stdout) for end in ends]
    for _, output in pipes:
        assert output and output.readline() == "ready\n"
    for number, (source, output) in enumerate(pipes):
        assert source and output
        source.write("\n")
        source.flush()
        output.readline()
        if number == 0:
            time.sleep(0.3)
    began = time.monotonic()
    assert pipes[0][0]
    pipes[0][0].write("\n")
    pipes[0][0].flush()
    if case in EVENTS:
        time.sleep(EVENT_AT_S)
    if case == "cut":
        cut()
    elif case == "restart":
        relay.terminate()
        relay.wait()
        relay = start_relay()
    elif case in EVENTS:
        forget(home, is_inbound=case == "deaf")
    at = time.monotonic()
    outputs = [end.communicate()[0] for end in ends]
    waiter, caller = (json.loads(output.splitlines()[-1]) for output in outputs)
    return _figures(waiter, caller, caller["began"], at if case in EVENTS else began), relay


def _figures(waiter: dict[str, Any], caller: dict[str, Any], began: float, event: float) -> dict[str, Any]:
    paths = [end["paths"] for end in (waiter, caller)]
    direct = [next((at for at, name in path if name == "direct"), None) for path in paths]
    back = [[at for at, name in path if name != "direct" and at > event] for path in paths]
    ended = min(end["ended"] for end in (waiter, caller))
    later = [[*(at for at in end["frames"] if event - 1 < at < ended), ended] for end in (waiter, caller)]
    gaps = [max((b - a for a, b in pairwise(at)), default=None) for at in later]
    connected = caller["paths"][0][0] - began if caller["paths"] else None
    talking_s = [end["frames"][0] - began if end["frames"] else None for end in (waiter, caller)]
    return {
        "connected_s": connected,
        "talking_s": None if None in talking_s else max(talking_s),  # type: ignore[type-var]
        "direct_s": None if None in direct else max(direct) - began,  # type: ignore[type-var, operator]
        "back_s": max(at[0] for at in back) - event if all(back) and None not in direct else None,
        "gap_s": None if None in gaps else max(gaps),  # type: ignore[type-var]
        "last": [path[-1][1] if path else "" for path in paths],
        "sessions": [waiter["sessions"], caller["sessions"]],
        "round_trip_ms": caller["round_trip_ms"],
    }


def measure(case: str, runs: int) -> list[dict[str, Any]]:
    """Return the figures of some calls of a kind."""
    build(case)
    relay = start_relay()
    time.sleep(3)
    results = []
    try:
        for number in range(runs):
            figures, relay = run_call(case, relay, "ab"[number % 2])
            results.append(figures)
            if case == "cut":
                build(case)
                relay.terminate()
                relay = start_relay()
                time.sleep(3)
    finally:
        relay.terminate()
        relay.wait()
        tear_down()
    return results


def main() -> None:
    """Measure, or be one end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--case", nargs="+", choices=list(SECONDS), default=list(SECONDS))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--probe", choices=["wait", "call"], help=argparse.SUPPRESS)
    parser.add_argument("--code", help=argparse.SUPPRESS)
    parser.add_argument("--seconds", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.probe:
        probe(options.code, options.seconds, is_caller=options.probe == "call")
        return
    results = {case: measure(case, options.runs) for case in options.case}
    if options.json:
        print(json.dumps(results))
        return
    for case, calls in results.items():
        for name in ("connected_s", "talking_s", "direct_s", "back_s", "gap_s", "round_trip_ms"):
            values = sorted(call[name] for call in calls if call[name] is not None)
            text = f"{values[len(values) // 2]:8.2f} median {values[-1]:8.2f} max" if values else ""
            print(f"{case:10} {name:14} {len(values):3} of {len(calls)} {text}")
        print(f"{case:10} last {sorted({str(call['last']) for call in calls})}, "
              f"sessions {sorted({str(call['sessions']) for call in calls})}")  # fmt: skip


if __name__ == "__main__":
    main()
