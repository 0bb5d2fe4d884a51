"""Be a hostile peer that knows the code: sealed datagrams with bodies of every kind, damaged, endless and flickering.

    python tools/network/fuzz_peer.py [--datagrams 1000000] [--seed 1] [--json]

The peer calls two victims: a receiver of many callers, which has an honest caller at the same time, and, over a relay,
a call of two. It sends damaged bodies of real calls and of the golden files, random bytes, chunks of objects that never
end, names and cameras that change with each datagram, voice formats, floods of path probes and path candidates, and
datagrams from ever new addresses. Now and then it hangs up and calls again. Half of the datagrams go to each victim.
The program ends with an error at the first exception, when the honest call loses a frame, when more is sent to the peer
than it sends, when more than 20 probes and 20 answers a second go to addresses that it only pretends to have, or when
memory grows.
"""

import random
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.errors import ProtocolError
from conf.protocol.address import Address, RelayAddress
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import (
    Bye,
    Composite,
    MotionFrame,
    ParticipantMessage,
    VoiceFormatMessage,
    VoiceStateMessage,
)
from conf.protocol.participant.state import MAX_HEAD, CameraState
from conf.protocol.portrait.chunks import MAX_OBJECT_BYTES, Chunk, encode_chunk
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.paths.candidates import MAX_CANDIDATES, MAX_REVISION, PathCandidates
from conf.protocol.session.paths.validation import PATH_ANSWER, PATH_PROBE, PER_SECOND, TOKEN_BYTES
from conf.protocol.session.server import SessionServer
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.wire import FURROWS, MAX_BODY, PORTRAIT_CHUNK, decode_body, encode_body
from tests.support.simulated_calls import frown, talk
from tests.support.synthetic_motion import talking
from tests.support.two_way_call import Losses, TwoWayCall
from tools.bench.session import CODE, RECEIVER, SENDER, mutate
from tools.golden.codec import FOLDER
from tools.network.fuzz_wire import MAX_GROWTH_KB, PARAMETERS, WARM_UP, memory_kb
from tools.network.fuzzer import run_fuzzer

HOSTILE: Address = ("203.0.113.9", 9)
PER_FRAME = 100  # datagrams to each victim in the time of an honest frame: 1,500 a second
FPS = 15.0
CHUNK_BYTES = 80
BYE_EACH = 19_999  # bodies; odd, as the two peers take turns
BYE = encode_body(Bye())
MAX_SENT_FRACTION = 1.0  # bytes sent to the peer for each of its own
FACES = talking(200)


def is_bye(data: bytes) -> bool:
    """Return whether a body ends the call."""
    try:
        body = decode_body(data)
    except ProtocolError:
        return False
    return any(isinstance(part, Bye) for part in (body.bodies if isinstance(body, Composite) else (body,)))


class HostileBodies:
    """Bodies that a hostile peer sends."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._known = [path.read_bytes() for path in sorted(FOLDER.glob("body_*.bin"))]
        for kbps in (16.0, 4.8):
            rate = RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC)
            call = TwoWayCall(rate, motions=(frown, talk), losses=Losses(0.2), seed=seed)
            call.run(8)
            self._known += call.a.bodies
        self._count = 0

    def next(self) -> bytes:
        """Return a body. Few of them are byes: while there is no session nothing else can be sent."""
        self._count += 1
        makers = (
            *(self._damaged, self._damaged, self._noise, self._chunk),
            *(self._participant, self._voice, self._path, self._furrows),
        )
        body = makers[self._count % len(makers)]()[: MAX_BODY + 1]
        while is_bye(body) and self._count % BYE_EACH:
            body = self._damaged()[:MAX_BODY]
        return BYE if self._count % BYE_EACH == 0 else body

    def _damaged(self) -> bytes:
        body = self._random.choice(self._known) or b"\0"
        if self._random.random() < 0.2:
            body = self._random.choice(self._known)[: self._random.randrange(60)] + body
        return mutate(body, self._random)

    def _noise(self) -> bytes:
        kind = self._random.randrange(256)
        return bytes((kind,)) + self._random.randbytes(self._random.choice((0, 1, 8, 40, MAX_BODY)))

    def _chunk(self) -> bytes:
        """Return one of the last chunks of an object that never ends, or of a complete object of junk."""
        if self._random.random() < 0.1:
            data = self._random.randbytes(CHUNK_BYTES)
            chunk = Chunk(self._random.randrange(1 << 16), CHUNK_BYTES, 0, CHUNK_BYTES, data)
        else:
            number, index = self._random.randrange(1 << 16), self._random.randrange(MAX_OBJECT_BYTES // CHUNK_BYTES)
            chunk = Chunk(number, CHUNK_BYTES, index, MAX_OBJECT_BYTES, bytes(CHUNK_BYTES))
        return bytes((PORTRAIT_CHUNK,)) + encode_chunk(chunk)

    def _participant(self) -> bytes:
        camera = (CameraState.ON, CameraState.OFF)[self._count % 2]
        return encode_body(ParticipantMessage(str(self._count), camera, head=self._random.randrange(MAX_HEAD + 1)))

    def _voice(self) -> bytes:
        if self._random.random() < 0.5:
            return encode_body(VoiceStateMessage(self._random.choice(_STATES), self._random.randrange(128)))
        bit_rate, frames = self._random.randrange(100, 510_000), self._random.randrange(1, 10)
        made = VoiceFormat("opus", bit_rate, 20, frames, fixed_size=self._random.random() < 0.5)
        return encode_body(VoiceFormatMessage(self._random.randrange(16), made))

    def _furrows(self) -> bytes:
        return bytes((FURROWS, self._random.randrange(256)))

    def _path(self) -> bytes:
        if self._random.random() < 0.5:
            return bytes((self._random.choice((PATH_PROBE, PATH_ANSWER)),)) + self._random.randbytes(TOKEN_BYTES)
        revision, seen = self._random.randrange(1, MAX_REVISION + 1), self._random.randrange(MAX_REVISION + 1)
        hosts = self._random.choices(range(256), k=self._random.randrange(MAX_CANDIDATES + 1))
        addresses = tuple((f"198.51.100.{host}", self._random.randrange(1 << 16)) for host in hosts)
        return encode_body(PathCandidates(revision, seen, self._random.random() < 0.5, addresses))


_STATES = [state for state in VoiceState if state is not VoiceState.TALKING]


class Peer:
    """The hostile peer of one victim.

    connections : how often it has connected; sent_bytes, received_bytes : by it and for it
    elsewhere : datagrams for addresses that it only pretends to have
    """

    def __init__(
        self, victim: ReceiverEndpoint | CallEndpoint, bodies: HostileBodies, seed: int, address: Address = HOSTILE
    ) -> None:
        self._address = address
        self._victim = victim
        self._bodies = bodies
        self._random = random.Random(f"peer {seed}")
        self._session = self._new_session(0.0)
        self.connections = self.sent_bytes = self.received_bytes = self.elsewhere = 0

    def attack(self, now: float) -> None:
        """Send one datagram, or a part of the handshake while there is no session."""
        body = self._bodies.next()
        sealed = self._session.seal_body(body)
        if sealed is None:
            for data, _ in self._session.datagrams_to_send(now):
                self._send(data, self._address, now)
            return
        pretended = self._random.random() < 0.05
        host = f"203.0.113.{self._random.randrange(100, 200)}"
        self._send(sealed.datagram, (host, self._random.randrange(1 << 16)) if pretended else self._address, now)
        if body == BYE:
            self._session = self._new_session(now)

    def receive(self, data: bytes, address: Address, now: float) -> None:
        """Receive what a victim has sent to this peer; start again if the victim does not know the session."""
        self.received_bytes += len(data)
        self.elsewhere += address != self._address
        if address != self._address:
            return
        before = self._session.session
        self._session.receive_datagram(data, RECEIVER, now)
        self.connections += before is None and self._session.session is not None
        is_unknown = data[0] == 0x93 and data[2] == 6 and before is not None
        if is_unknown or self._session.stopped:
            self._session = self._new_session(now)

    def _new_session(self, now: float) -> SenderSession:
        return SenderSession(CODE, RECEIVER, self._random.randbytes, now)

    def _send(self, data: bytes, address: Address, now: float) -> None:
        self.sent_bytes += len(data)
        self._victim.receive_datagram(data, address, now)


class Attack:
    """Two victims, their peers, and an honest caller."""

    def __init__(self, seed: int) -> None:
        rng, bodies = random.Random(seed), HostileBodies(seed)
        self.receiver = ReceiverEndpoint(SessionServer(CODE, rng.randbytes))
        self.honest = SenderConnection(SenderSession(CODE, RECEIVER, rng.randbytes, 0.0), PARAMETERS, 0.0)
        rate = RateOptions(kbps=16.0, voice=VoiceMode.AUTOMATIC)
        self.call = CallEndpoint(code=CODE, parameters=PARAMETERS, now=0.0, random=rng.randbytes, rate=rate, name="Ada")
        self.peers = (
            Peer(self.receiver, bodies, seed),
            Peer(self.call, bodies, seed + 1, RelayAddress("4711", "hostile")),
        )
        self.frame = 0
        self._play_honestly(0.0)

    @property
    def now(self) -> float:
        """The time of the newest honest frame."""
        return self.frame / FPS

    def run_frame(self) -> None:
        """Let the time of an honest frame pass, full of attacks."""
        begin = self.now
        self.frame += 1
        for number in range(PER_FRAME):
            for peer in self.peers:
                peer.attack(begin + number / PER_FRAME / FPS)
            if number % 25 == 0:
                self._answer(begin + number / PER_FRAME / FPS)
        self._play_honestly(self.now)
        self._use_call(self.now)
        self._answer(self.now)

    def honest_frames(self) -> int:
        """Return how many frames of the honest caller have been received."""
        number = self.honest._session.session
        return self.receiver.streams[number].motion.frames.count if number in self.receiver.streams else 0

    def _play_honestly(self, now: float) -> None:
        face = FACES[self.frame % len(FACES)]
        self.honest.send_frame(MotionFrame(now, face.displacements, face.pose), now)
        for data, _ in self.honest.datagrams_to_send(now):
            self.receiver.receive_datagram(data, SENDER, now)

    def _use_call(self, now: float) -> None:
        """Talk, play and draw."""
        face = FACES[self.frame % len(FACES)]
        self.call.send_frame(MotionFrame(now, face.displacements, face.pose), now)
        if voice_format := self.call.voice_format:
            frames = (bytes(-(-voice_format.frame_bits // 8)),) * voice_format.frames
            self.call.send_voice(VoicePacket(now, voice_format, frames), now)
        for end in (self.call, self.receiver):
            for stream in end.streams.values():
                stream.voice.frames_until(stream.clock.playhead(now))
                stream.motion.frame_at(now)
            end.snapshot(now)
            while end.next_event():
                pass
        _ = self.call.remote_state

    def _answer(self, now: float) -> None:
        for data, address in self.receiver.datagrams_to_send(now):
            if address == SENDER:
                self.honest.receive_datagram(data, RECEIVER, now)
            else:
                self.peers[0].receive(data, address, now)
        for data, address in self.call.datagrams_to_send(now):
            self.peers[1].receive(data, address, now)


def fuzz(count: int, seed: int) -> dict[str, Any]:
    """Send about `count` datagrams and return the figures. Exits with a message at the first fault."""
    attack, memory, start = Attack(seed), 0, time.perf_counter()
    frames = -(-count // (2 * PER_FRAME))
    for frame in range(frames):
        _guarded(attack.run_frame, frame)
        if frame == WARM_UP // (2 * PER_FRAME):
            memory = memory_kb()
        if frame % 500 == 499:
            print(2 * PER_FRAME * (frame + 1), f"{time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
    growth = memory_kb() - memory if memory else 0
    _check(attack, growth)
    return {
        "datagrams": 2 * PER_FRAME * frames,
        "connections": [peer.connections for peer in attack.peers],
        "rejected": [attack.receiver.rejected, attack.call.rejected],
        "bytes_sent_by_the_peer": [peer.sent_bytes for peer in attack.peers],
        "bytes_sent_to_the_peer": [peer.received_bytes for peer in attack.peers],
        "datagrams_to_pretended_addresses": [peer.elsewhere for peer in attack.peers],
        "honest_frames_sent": attack.honest.outbound.frames_sent,
        "honest_frames_received": attack.honest_frames(),
        "memory_growth_kb": growth,
        "seconds": round(time.perf_counter() - start, 1),
    }


def _guarded(work: Callable[[], None], frame: int) -> None:
    try:
        work()
    except Exception as error:
        sys.exit(f"{error!r} in frame {frame}")


def _check(attack: Attack, growth: int) -> None:
    sent, received = attack.honest.outbound.frames_sent, attack.honest_frames()
    if received < sent:
        sys.exit(f"the honest call lost frames: {received} of {sent} arrived")
    for peer in attack.peers:
        if peer.received_bytes > MAX_SENT_FRACTION * peer.sent_bytes:
            sys.exit(f"{peer.received_bytes} bytes were sent to a peer that had sent {peer.sent_bytes}")
        # Probes and answers; each new session may begin with full buckets.
        if peer.elsewhere > 2 * PER_SECOND * (attack.now + 1 + peer.connections):
            sys.exit(f"{peer.elsewhere} datagrams went to addresses that a peer pretended to have")
    if growth > MAX_GROWTH_KB:
        sys.exit(f"memory grew by {growth} kB; at most {MAX_GROWTH_KB} kB are allowed")


if __name__ == "__main__":
    run_fuzzer(fuzz, __doc__)
