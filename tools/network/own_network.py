"""A network of one's own for a measurement: a namespace with nothing but a loopback, and a capture of what passes."""

import os
import socket
import struct
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.stoppable_thread import StoppableThread

INSIDE = "CONF_OWN_NETWORK"
OUTGOING = 4  # packet type; on a loopback each packet is seen twice, outgoing and incoming
IPV4, TCP, UDP = 0x0800, 6, 17


def enter_own_network() -> None:
    """Run this program again in a network namespace of its own; return there. Needs Linux and the right to make one."""
    if os.environ.get(INSIDE):
        subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
        return
    os.environ[INSIDE] = "1"
    os.execvp("unshare", ["unshare", "--net", sys.executable, *sys.argv])


@dataclass(frozen=True)
class Packet:
    """An IPv4 packet. size : with the IP header; payload : behind the UDP or TCP header"""

    kind: str
    source: int
    destination: int
    size: int
    payload: bytes


class Capture:
    """All TCP and UDP packets on the loopback while the `with` block lasts; `packets` in their order."""

    def __init__(self) -> None:
        self.packets: list[Packet] = []
        self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(IPV4))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16 << 20)
        self._socket.bind(("lo", 0))
        self._socket.settimeout(0.1)
        self._thread = StoppableThread(self._run, name="capture")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.stop()
        self._socket.close()

    def sizes(self, *, kind: str, source: int | None = None, destination: int | None = None) -> Counter[int]:
        """Return how many packets had each size."""
        return Counter(
            packet.size
            for packet in self.packets
            if packet.kind == kind and source in (None, packet.source) and destination in (None, packet.destination)
        )

    def _run(self) -> None:
        while not self._thread.is_stopped:
            try:
                data, (_, _, packet_type, *_) = self._socket.recvfrom(1 << 16)
            except TimeoutError:
                continue
            if packet_type != OUTGOING and (packet := parse_packet(data[14:])):
                self.packets.append(packet)


def parse_packet(data: bytes, /) -> Packet | None:
    """Return an IPv4 packet with TCP or UDP inside, None for anything else."""
    if len(data) < 20 or data[0] >> 4 != 4 or data[9] not in (TCP, UDP):
        return None
    header = (data[0] & 15) * 4
    (size,) = struct.unpack_from(">H", data, 2)
    source, destination = struct.unpack_from(">HH", data, header)
    start = header + (8 if data[9] == UDP else (data[header + 12] >> 4) * 4)
    return Packet("udp" if data[9] == UDP else "tcp", source, destination, size, data[start:size])
