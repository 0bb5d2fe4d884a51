"""Measure what a call of two costs and carries: two people talk, reports ride in what they send.

    python tools/bench/two_way_call.py [--seconds 40] [--loss 0 0.05] [--json]
    python tools/bench/two_way_call.py --voice [--rates 16 9.6 6 4.8 2.4] [--clips CLIP CLIP ...] [--json]

Without --voice: the motion tracks talk_1 and talk_4 of ../shared/motion, no voice, 80 ms of round trip. Datagrams are
counted where the network would take them, with 28 B of headers each, after the handshake. Beside it the cost of one way
as `conf send` and `conf receive` have it: what the sender sends and what the receiver reports.

--voice: voice and face both ways under a limit each way, in pairs of the talking clips of ../shared/media. STOI, face
error and delay are measured as voice.py does, with the sound and the frames of each direction.
"""

import argparse
import json
import os
import random
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.audio.processing import VoiceProcessor
from conf.audio.samples import Samples
from conf.protocol.address import Address
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.sender.frame_pacer import FramePacer
from conf.sender.voice.voice_sender import VoiceSender
from tools.bench.tracks import Track, TrackReader
from tools.bench.voice import CLIPS, FPS, RATES, SHARED, compare, read_subject
from tools.bench.voice_link import CODE, DRAW_STEPS, ONE_WAY_S, POLL_STEPS, STEP_S, LoopedSound, Loss, VoiceCall, watch

A, B = ("a", 1), ("b", 2)
HANDSHAKE_S = 3.0
PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
TALKERS = ("talk_1", "talk_4")
PROFILE_FPS = 15.0
MAX_KBPS = {"live": 5.4, "narrow": 2.3}  # of each direction, without loss


class End(Protocol):
    """An end of a call."""

    def receive_datagram(self, data: bytes, address: Address, now: float, /) -> None: ...
    def datagrams_to_send(self, now: float, /) -> list[tuple[bytes, Address]]: ...


class Network:
    """Two ends and the link between them.

    sent : (time, bytes with headers) of the datagrams of each end after the handshake
    """

    def __init__(self, ends: tuple[End, End], loss: Loss, seed: int) -> None:
        self._ends = ends
        self._loss = loss
        self._random = random.Random(seed)
        self._burst = [0, 0]
        self._queues: tuple[list[tuple[float, bytes]], list[tuple[float, bytes]]] = ([], [])  # to each end
        self.sent: tuple[list[tuple[float, int]], list[tuple[float, int]]] = ([], [])

    def deliver(self, now: float) -> None:
        """Let what has arrived by now arrive."""
        for end, queue, source in zip(self._ends, self._queues, (B, A), strict=True):
            while queue and queue[0][0] <= now:
                arrival, data = queue.pop(0)
                end.receive_datagram(data, source, arrival)

    def send(self, now: float) -> None:
        """Send what is due."""
        for index, end in enumerate(self._ends):
            for data, _ in end.datagrams_to_send(now):
                if now >= 0:
                    self.sent[index].append((now, len(data) + HEADER_BYTES))
                if now < 0 or not self._is_lost(index):
                    self._queues[1 - index].append((now + ONE_WAY_S, data))

    def _is_lost(self, index: int) -> bool:
        if self._burst[index]:
            self._burst[index] -= 1
            return True
        if self._random.random() < self._loss.fraction / self._loss.burst:
            self._burst[index] = self._loss.burst - 1
            return True
        return False


def times(seconds: float, step_s: float = STEP_S) -> Iterator[tuple[int, float]]:
    """Yield the number and the time of each step, the first of the call at 0 after the handshake."""
    for step in range(-round(HANDSHAKE_S / step_s), round(seconds / step_s)):
        yield step, step * step_s


def endpoints(rate: RateOptions, seed: int) -> tuple[CallEndpoint, CallEndpoint]:
    """Return an end that is called and one that calls it."""

    def endpoint(label: str, remote: Address | None) -> CallEndpoint:
        generator = random.Random(f"{label} {seed}")
        return CallEndpoint(
            code=CODE,
            parameters=PARAMETERS,
            now=-HANDSHAKE_S,
            random=generator.randbytes,
            remote=remote,
            rate=rate,
            name=label,
        )

    return endpoint("Ada", None), endpoint("Bob", A)


def talk(senders: list[SenderConnection], tracks: list[Track]) -> Callable[[float], None]:
    """Return what sends the frames of each talker that are due."""
    sent = 0

    def tick(now: float) -> None:
        nonlocal sent
        while now >= 0 and sent / PROFILE_FPS <= now:
            for sender, track in zip(senders, tracks, strict=True):
                frame = track.frames[sent % len(track.frames)]
                sender.send_frame(MotionFrame(sent / PROFILE_FPS, frame.displacements, frame.pose), now)
            sent += 1

    return tick


def run(ends: tuple[End, End], tick: Callable[[float], None], seconds: float, loss: Loss, seed: int) -> Network:
    """Hold a call."""
    network = Network(ends, loss, seed)
    for _, now in times(seconds):
        network.deliver(now)
        tick(now)
        network.send(now)
    return network


def kbps(sent: list[tuple[float, int]], seconds: float) -> float:
    """Return a mean rate."""
    return sum(size for _, size in sent) * 8 / 1000 / seconds


def measure_cost(profile: str, loss: float, tracks: list[Track], seconds: float, seed: int) -> dict[str, float]:
    """Return kbit/s of each direction of a call of two, and of one way: sender and reports."""
    rate = RateOptions(profile)
    ends = endpoints(rate, seed)
    network = run(ends, talk(list(ends), tracks), seconds, Loss(loss), seed)
    streams = [stream for end in ends for stream in end.streams.values()]
    result = {
        f"{name}_kbps": kbps(network.sent[index], seconds) for index, name in enumerate(track.name for track in tracks)
    }
    result |= {
        "datagrams_per_s": sum(map(len, network.sent)) / 2 / seconds,
        "missed_references": sum(stream.missed_references for stream in streams),
        "rejected": sum(end.rejected for end in ends),
    }
    for track in tracks:
        session = SenderSession(CODE, A, random.Random(seed).randbytes, -HANDSHAKE_S)
        sender = SenderConnection(session, PARAMETERS, -HANDSHAKE_S, rate=rate)
        receiver = ReceiverEndpoint(SessionServer(CODE, random.Random(seed + 1).randbytes))
        network = run((receiver, sender), talk([sender], [track]), seconds, Loss(loss), seed)
        result[f"{track.name}_one_way_kbps"] = kbps(network.sent[1], seconds)
        result[f"{track.name}_one_way_reports_kbps"] = kbps(network.sent[0], seconds)
    return result


class Person:
    """One end of a call with voice, and the person in front of it.

    result : what the other end gets of this person
    """

    def __init__(self, endpoint: CallEndpoint, subject: tuple[Track | None, Samples], seconds: float) -> None:
        self.endpoint = endpoint
        self.track, self.sound = subject
        self.result = VoiceCall(seconds)
        self._source = VoiceSender(LoopedSound(self.sound), VoiceProcessor())
        self._output = ClipSound(VoiceMixer(endpoint.streams, np.random.default_rng(1)))
        self._pacer, self._next_frame = FramePacer(PROFILE_FPS), 0
        self._watched = False

    def capture(self, step: int, now: float) -> None:
        """Send what is due."""
        while self.track is not None and self._next_frame / FPS <= now:
            frame = self.track.frames[self._next_frame % len(self.track.frames)]
            timestamp, self._next_frame = self._next_frame / FPS, self._next_frame + 1
            self._pacer.fps = self.endpoint.outbound.profile.fps
            if self._pacer.delay_for(timestamp, now) is not None:
                self.endpoint.send_frame(MotionFrame(timestamp, frame.displacements, frame.pose), now)
        if step % POLL_STEPS == 0:
            self._source.poll(now, self.endpoint, now)

    def play(self, other: "Person", step: int, now: float) -> None:
        """Hear and see the other person."""
        if step % POLL_STEPS == 0:
            blocks = self._output.recorded(now)
            if blocks and not other.result.heard:
                other.result.heard_at = blocks[0].timestamp
            other.result.heard += [block.samples for block in blocks]
        if step % DRAW_STEPS == 0:
            for stream in self.endpoint.streams.values():
                stream.motion.frame_at(now)
        if other.track is not None and self.endpoint.streams and not self._watched:
            self._watched = True
            watch(self.endpoint.streams, other.track, FPS, other.result)


@dataclass(frozen=True)
class Direction:
    """What one direction of a call measured. worst_kbps : of the worst ten seconds; delay_ms : from mouth to ear"""

    clip: str
    kbps: float
    worst_kbps: float
    stoi: float
    face_error_percent: float
    delay_ms: float


def measure_voice(pair: tuple[Path, Path], rate: float, loss: float, seconds: float, seed: int) -> list[Direction]:
    """Hold a call of two with voice under a limit each way."""
    ends = endpoints(RateOptions(kbps=rate, voice=VoiceMode.AUTOMATIC), seed)
    a, b = (Person(end, read_subject(path), seconds) for end, path in zip(ends, pair, strict=True))
    network = Network(ends, Loss(loss), seed)
    for step, now in times(seconds):
        network.deliver(now)
        for person in (a, b) if now >= 0 else ():
            person.capture(step, now)
        network.send(now)
        if now >= 0:
            a.play(b, step, now)
            b.play(a, step, now)
    directions = []
    for person, sent, path in zip((a, b), network.sent, pair, strict=True):
        person.result.sent = sent
        scores, delay = compare(person.sound, person.result)
        errors = person.result.errors
        directions.append(
            Direction(
                path.stem,
                person.result.kbps,
                person.result.worst_kbps,
                scores.filtered,
                float(np.mean(errors)) if errors else float("nan"),
                1000 * delay,
            )
        )
    return directions


def costs(options: argparse.Namespace) -> list[dict[str, object]]:
    """Measure the cost of each profile at each loss; print a line for each."""
    reader, rows = TrackReader(), []
    tracks = [reader.read(SHARED / "motion" / f"{name}.npz", fps=PROFILE_FPS) for name in TALKERS]
    for profile, limit in MAX_KBPS.items():
        for loss in options.loss:
            found = measure_cost(profile, loss, tracks, options.seconds, options.seed)
            rows.append({"profile": profile, "loss": loss, **found})
            if not options.json:
                ways = [found[f"{name}_kbps"] for name in TALKERS]
                one = [f"{found[f'{n}_one_way_kbps']:.2f} + {found[f'{n}_one_way_reports_kbps']:.2f}" for n in TALKERS]
                print(
                    f"{profile:7} loss {loss:3.0%}  each direction {ways[0]:.2f} and {ways[1]:.2f} kbit/s"
                    f" (at most {limit}), {found['datagrams_per_s']:.1f} datagrams/s;"
                    f" one way {one[0]} and {one[1]}; missed references {found['missed_references']:.0f},"
                    f" rejected {found['rejected']:.0f}",
                    flush=True,
                )
    return rows


def voices(options: argparse.Namespace) -> list[dict[str, object]]:
    """Measure each rate and loss over all pairs of clips; print a line for each."""
    rows: list[dict[str, object]] = []
    for rate in options.rates:
        for loss in options.loss:
            found = [
                direction
                for pair in zip(options.clips[::2], options.clips[1::2], strict=True)
                for direction in measure_voice(pair, rate, loss, options.seconds, options.seed)
            ]
            mean = {
                "worst_kbps": max(direction.worst_kbps for direction in found),
                "kbps": float(np.mean([direction.kbps for direction in found])),
                "stoi": float(np.mean([direction.stoi for direction in found])),
                "face_error_percent": float(np.nanmean([direction.face_error_percent for direction in found])),
                "delay_ms": float(np.median([direction.delay_ms for direction in found])),
            }
            rows.append({"rate": rate, "loss": loss, **mean, "directions": [asdict(direction) for direction in found]})
            if not options.json:
                print(
                    f"{rate:5g} kbit/s each way, loss {loss:3.0%}: {mean['kbps']:5.2f} kbit/s"
                    f" (worst {mean['worst_kbps']:5.2f}), STOI {mean['stoi']:.3f},"
                    f" face {mean['face_error_percent']:.2f} %, delay {mean['delay_ms']:.0f} ms",
                    flush=True,
                )
    return rows


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--voice", action="store_true", help="voice and face both ways, under a limit")
    parser.add_argument("--rates", nargs="+", type=float, default=RATES, metavar="KBPS")
    parser.add_argument("--clips", nargs="+", type=Path, default=CLIPS, metavar="CLIP", help="two for each call")
    parser.add_argument("--loss", nargs="+", type=float, default=(0.0, 0.05), metavar="FRACTION")
    parser.add_argument("--seconds", type=float, default=40.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    options = parser.parse_args()
    rows = voices(options) if options.voice else costs(options)
    if options.json:
        print(json.dumps({"voice" if options.voice else "cost": rows}))


if __name__ == "__main__":
    main()
