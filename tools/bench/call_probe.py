"""One end of a real call, watched: what `conf send` and `conf receive` do, with a note of every frame and picture.

    python tools/bench/call_probe.py receive 127.0.0.1:0 CODE SECONDS
    python tools/bench/call_probe.py send 127.0.0.1:5005 CODE SECONDS CLIP [--portrait]

It prints JSON, one object a line. The receiver: where it listens, then each second its figures, the pictures it has
shown and when each caller's portrait was first drawn; the sender: each second its memory, when it began to call, the
frames it has taken and the datagrams it has sent. All times are of the machine's monotonic clock, which both processes
share. The face is drawn but not recorded. tools/network/soak.py, bench_latency.py, bench_flood.py and
bench_portrait_start.py read it.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import IO, Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.commands.receive import SIZE, WINDOW_FPS
from conf.commands.send import SendOptions
from conf.commands.send import send as send_face
from conf.errors import NetworkError
from conf.face.loading import load_face
from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.receiver.pipeline import LoopOptions, ReceiverLoop
from conf.render.window.offscreen import OffscreenWindow
from conf.sender import pipeline
from conf.sender.pipeline import SenderLoop, SenderStatus
from conf.transport.udp import UdpSocket

EVERY_S = 1.0


def memory_kb() -> int:
    """Return the memory this process occupies (RSS) in kB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def tell(**what: Any) -> None:
    """Print one object."""
    print(json.dumps(what), flush=True)


class WatchedWindow(OffscreenWindow):
    """A window that notes when each picture was finished and what it showed.

    pictures : (finished at, playhead on the stream's clock, seconds the playhead is past the newest frame)
    portraits : when each caller's was first drawn
    """

    def __init__(self, host: ReceiverEndpoint) -> None:
        super().__init__(*SIZE)
        self.pictures: list[tuple[float, float, float]] = []
        self.portraits: dict[int, float] = {}
        self._host = host
        self._due = 0.0

    def end(self) -> None:
        """Finish the picture and note it."""
        self.ctx.finish()
        now = time.monotonic()
        self.pictures += [
            (now, float(leg.motion.buffer.playhead), max(0.0, float(leg.motion.buffer.playhead) - newest))
            for leg in self._host.streams.values()
            if (newest := leg.motion.buffer.newest) is not None
        ]
        if now >= self._due:
            self._due = now + EVERY_S
            missed = sum(leg.missed_references for leg in self._host.streams.values())
            counts = {"callers": len(self._host.streams), "missed_references": missed, "portraits": self.portraits}
            tell(at=now, memory_kb=memory_kb(), **counts, **asdict(self._host.snapshot(now)), pictures=self.pictures)
            self.pictures = []


class WatchedReceiverLoop(ReceiverLoop):
    """A loop that notes when each caller's portrait was first drawn."""

    def step(self, now: float) -> float:
        due = super().step(now)
        assert isinstance(self._window, WatchedWindow)
        for caller, portrait in self._composer._grid._portraits.items():
            if portrait.ready and self._composer._frames.get(caller):
                self._window.portraits.setdefault(caller, time.monotonic())
        return due


class WatchedSendingLoop(SenderLoop):
    """A loop that notes when the call began, when each frame was taken, and what was sent.

    datagrams : (sent at, bytes with headers, how many of them for the portrait)
    """

    frames: list[tuple[float, float]]
    datagrams: list[tuple[float, int, int]]
    began = taken = due = 0.0

    def run(
        self,
        *,
        seconds: float | None = None,
        on_status: Callable[[SenderStatus], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> SenderStatus:
        """Note the time and send."""
        self.began = time.monotonic()
        self.datagrams = []
        put, before = self._socket.send, 0
        track = self._source.motion

        def motion() -> MotionFrame | None:
            self.taken = time.monotonic()
            return track()

        def send(datagrams: list[tuple[bytes, Address]]) -> None:
            nonlocal before
            total = self._connection._leg.budget.chunks.bytes_sent
            if datagrams:
                size = sum(len(data) + HEADER_BYTES for data, _ in datagrams)
                self.datagrams.append((time.monotonic(), size, total - before))
            before = total
            put(datagrams)

        self._socket.send = send  # type: ignore[method-assign]
        self._source.motion = motion  # type: ignore[method-assign]
        return super().run(seconds=seconds, on_status=on_status, clock=clock)

    def _send(self, timestamp: float, motion: MotionFrame | None) -> None:
        self.frames = [*getattr(self, "frames", []), (self.taken, timestamp)]
        super()._send(timestamp, motion)
        if self.taken >= self.due:
            self.due = self.taken + EVERY_S
            status = asdict(self.status(self._now))
            what = {"frames": self.frames, "datagrams": self.datagrams}
            tell(at=self.taken, began=self.began, memory_kb=memory_kb(), **what, **status)
            self.frames, self.datagrams = [], []


def receive(address: tuple[str, int], code: str, seconds: float) -> None:
    """Receive as `conf receive` does, at the rate of its window."""
    callers = ReceiverEndpoint(SessionServer(code, os.urandom))
    window = WatchedWindow(callers)
    with UdpSocket.bind(*address) as link, window:
        tell(listening="{}:{}".format(*link.address))
        loop = WatchedReceiverLoop(window, load_face(None), callers, link, LoopOptions(WINDOW_FPS))
        final = loop.run(seconds=seconds)
        tell(at=time.monotonic(), memory_kb=memory_kb(), **asdict(final), pictures=window.pictures)


def send(receiver: tuple[str, int], code: str, what: SendOptions) -> None:
    """Send a looped clip as `conf send` does."""
    pipeline.SenderLoop = WatchedSendingLoop  # type: ignore[misc]
    send_face(receiver, code, what)


def start(*arguments: object) -> subprocess.Popen[str]:
    """Start a probe in a process of its own."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, __file__, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


def start_receiver(code: str, seconds: float) -> tuple[subprocess.Popen[str], str]:
    """Start a receiver on loopback; return it and its address."""
    receiver = start("receive", "127.0.0.1:0", code, seconds)
    assert receiver.stdout is not None
    return receiver, json.loads(receiver.stdout.readline())["listening"]


def read_lines(stream: IO[str], into: list[dict[str, Any]]) -> None:
    """Take every object that a probe prints, until it ends; for a thread."""
    for line in stream:
        into.append(json.loads(line))


def split_address(text: str) -> tuple[str, int]:
    """Return host and port."""
    host, _, port = text.rpartition(":")
    return host, int(port)


def main() -> None:
    """Be one end of the call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("side", choices=["receive", "send"])
    parser.add_argument("address", type=split_address)
    parser.add_argument("code")
    parser.add_argument("seconds", type=float)
    parser.add_argument("clip", type=Path, nargs="?")
    parser.add_argument("--portrait", action="store_true", help="let pictures of the person be sent")
    options = parser.parse_args()
    if options.side == "receive":
        receive(options.address, options.code, options.seconds)
        return
    what = SendOptions(file=options.clip, loop=True, seconds=options.seconds)
    try:
        send(options.address, options.code, replace(what, portrait_kbps=4.0) if options.portrait else what)
    except NetworkError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
