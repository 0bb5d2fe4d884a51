"""Send mutated and random datagrams, and every truncation of every golden file, to a live call.

    python tools/network/fuzz_wire.py [--datagrams 1000000] [--seed 1] [--json]

The datagrams are sent to both ends of a running call of two, by somebody without the code; fuzz_peer.py is a peer with
it. Damaged message bodies, as a peer with a valid seal could send
them, go to a leg with both halves that sends and plays voice meanwhile: bodies of calls with voice, golden bodies, and
composites of parts of them. The program ends with an error at the first exception, at an answer larger than the
datagram it answers, at any change of the call's state, or when memory grows. One datagram in eight is random, the
others are damaged datagrams of the call or damaged golden files.
"""

import random
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.call_leg import CallLeg
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import SendLeg
from conf.protocol.voice.formats import VoicePacket
from tests.support.simulated_calls import frown, talk
from tests.support.synthetic_motion import talking
from tests.support.two_way_call import Losses, TwoWayCall
from tools.bench.session import CODE, RECEIVER, SENDER, mutate
from tools.golden.codec import FOLDER
from tools.network.fuzzer import run_fuzzer

STATM = Path("/proc/self/statm")
PAGE_KB = 4

UNKNOWN = ("203.0.113.9", 9)
MAX_GROWTH_KB = 8_000  # of the process: counters, caches, and the state that limits unknown addresses
WARM_UP = 20_000  # datagrams before memory is measured: then every bounded buffer is full
PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))


def memory_kb() -> int:
    """Return the resident memory of this process, kB, or 0 if the system does not report it."""
    return int(STATM.read_text().split()[1]) * PAGE_KB if STATM.exists() else 0


class LiveCall:
    """Two ends of a call without a network; both send and receive.

    recent : the last 500 datagrams of the call; valid : the same as a set
    """

    def __init__(self, seed: int) -> None:
        rng = random.Random(seed)
        self.host = CallEndpoint(code=CODE, parameters=PARAMETERS, now=0.0, random=rng.randbytes, name="Ada")
        self.caller = CallEndpoint(
            code=CODE, parameters=PARAMETERS, now=0.0, random=rng.randbytes, remote=RECEIVER, name="Bob"
        )
        self.recent: list[bytes] = []
        self.valid: set[bytes] = set()
        self.frames: list[MotionFrame] = talking(200)
        self.now = 0.0

    def play(self, frames: int) -> None:
        """Continue the call for so many frames."""
        for _ in range(frames):
            self.now += 1 / 15
            frame = self.frames[round(self.now * 15) % len(self.frames)]
            for end in (self.host, self.caller):
                end.send_frame(replace(frame, timestamp=self.now, furrow=frown(self.now).furrow), self.now)
            for data, _ in self.caller.datagrams_to_send(self.now):
                self.recent.append(data)
                self.host.receive_datagram(data, SENDER, self.now)
            for data, _ in self.host.datagrams_to_send(self.now):
                self.recent.append(data)
                self.caller.receive_datagram(data, RECEIVER, self.now)
        del self.recent[:-500]
        self.valid = set(self.recent)
        while self.host.next_event() or self.caller.next_event():
            pass

    def state(self) -> tuple[object, ...]:
        """Return the state that a datagram without a valid seal must not change."""
        return tuple(_state(end, self.now) for end in (self.host, self.caller))


def _state(end: CallEndpoint, now: float) -> tuple[object, ...]:
    legs = [
        (number, leg.traffic.total, leg.motion.frames.count, leg.rejected, leg.motion.presence, leg.name)
        for number, leg in end.streams.items()
    ]
    active = end._call._active
    assert active
    counters = active.opening_key.window.highest, active.sealing_key.counter
    return (*legs, active.number, active.address, active.last_received, *counters, end.status(now))


def datagrams(call: LiveCall, count: int, rng: random.Random) -> Iterator[bytes]:
    """Yield every truncation of every golden file, then `count` damaged and random datagrams, none of them valid."""
    golden = [path.read_bytes() for path in sorted(FOLDER.glob("*.bin"))]
    for data in golden:
        yield from (data[:size] for size in range(len(data) + 1))
    number = 0
    while number < count:
        if number % 8 == 0:
            data = rng.randbytes(rng.randrange(1300 if number % 64 == 0 else 80))
        else:
            data = mutate(rng.choice(call.recent if number % 2 else golden) or b"\0", rng)
        if data not in call.valid:
            number += 1
            yield data


def fuzz(count: int, seed: int) -> dict[str, Any]:
    """Send `count` datagrams to a call and return the figures. Exits with a message at the first fault."""
    rng, call = random.Random(seed), LiveCall(seed)
    call.play(60)
    victim, sent = Victim(seed), 0
    before, memory = call.state(), 0
    start = time.perf_counter()
    for data in datagrams(call, count, rng):
        sent += 1
        _send(call, data)
        _hit(victim, rng)
        if sent == WARM_UP:
            memory = memory_kb()
        if sent % 100_000 == 0:
            print(sent, f"{time.perf_counter() - start:.0f} s", file=sys.stderr)
        if sent % 1000 == 0:
            if call.state() != before:
                sys.exit(f"the state of the call changed within the 1000 datagrams before number {sent}")
            call.play(3)
            before = call.state()
    growth = memory_kb() - memory if sent > WARM_UP else 0
    if growth > MAX_GROWTH_KB:
        sys.exit(f"memory grew by {growth} kB; at most {MAX_GROWTH_KB} kB are allowed")
    return {
        "datagrams": sent,
        "bodies": victim.count,
        "bodies_refused": victim.receive.rejected + victim.receive.missed_references,
        "voice_frames": victim.voice_frames,
        "seconds": round(time.perf_counter() - start, 1),
        "memory_growth_kb": growth,
        "dropped": {str(k): v for k, v in sorted(call.host._call.dropped.items())},
        "frames_received_meanwhile": call.host.snapshot(call.now).frames_received,
    }


class Victim:
    """A leg that talks, and receives what a hostile peer sends. known : bodies of calls with voice, undamaged"""

    def __init__(self, seed: int) -> None:
        self.receive = ReceiveLeg()
        self.send = SendLeg(PARAMETERS, 0.0, rate=RateOptions(kbps=16.0, voice=VoiceMode.AUTOMATIC))
        self.leg = CallLeg(send=self.send, receive=self.receive)
        self.known = [path.read_bytes() for path in sorted(FOLDER.glob("body_[!i]*.bin"))]
        for kbps in (16.0, 4.8):
            rate = RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC)
            call = TwoWayCall(rate, motions=(frown, talk), losses=Losses(0.2), seed=seed)
            call.run(12)
            self.known += call.a.bodies
        self.count = self.voice_frames = 0
        self._now = 0.0
        self._begin()

    def hit(self, rng: random.Random) -> None:
        """Receive a damaged body, and now and then an undamaged one; send and play."""
        body = rng.choice(self.known)
        if self.count % 4:
            body = mutate(body, rng)
        if self.count % 8 == 1:
            body = rng.choice(self.known)[: rng.randrange(60)] + body
        self.leg.receive_body(body[:1185], self.count, len(body), self._now)
        self.count += 1
        self._now += rng.choice((0.0, 0.01, 0.06))
        if self.count % 10 == 0:
            self._talk(rng)
        if self.leg.ended or self.count % 20_000 == 0:
            self._begin()

    def _begin(self) -> None:
        self.leg.ended = False
        self.send.start(self._now)

    def _talk(self, rng: random.Random) -> None:
        if voice_format := self.send.voice_format:
            size = -(-voice_format.frame_bits // 8)
            frames = (bytes(size),) * voice_format.frames
            self.send.send_voice(VoicePacket(self._now, voice_format, frames), self._now)
        for outgoing in self.leg.bodies_to_send(self._now):
            self.leg.on_sent(self.count, outgoing, self._now)
        self.voice_frames += len(self.receive.voice.frames_until(self.receive.clock.playhead(self._now)))
        self.receive.motion.frame_at(self._now)


def _send(call: LiveCall, data: bytes) -> None:
    try:
        call.host.receive_datagram(data, UNKNOWN, call.now)
        call.caller.receive_datagram(data, RECEIVER, call.now)
    except Exception as error:
        sys.exit(f"{error!r} after {data.hex()}")
    for end in (call.host, call.caller):
        if sum(len(answer) for answer, _ in end._call.datagrams_to_send(call.now)) > len(data):
            sys.exit(f"the answer is larger than the datagram {data.hex()}")


def _hit(victim: Victim, rng: random.Random) -> None:
    try:
        victim.hit(rng)
    except Exception as error:
        sys.exit(f"{error!r} in the leg after {victim.count} bodies")


if __name__ == "__main__":
    run_fuzzer(fuzz, __doc__)
