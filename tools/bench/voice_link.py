"""Simulate a call with voice in simulated time: real sound and motion, real codecs, a lossy link, what comes out.

The sender sends a track's motion and a clip's sound as `conf send` does, the receiver renders the voice as for a clip.
Times: what is heard is compared with what was captured.
"""

import random
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conf.audio.processing import VoiceProcessor
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.sender.frame_pacer import FramePacer
from conf.sender.voice.voice_sender import VoiceSender
from tools.bench.tracks import Track

Sound = Samples | NDArray[np.floating]
CODE = "amber-canoe-tiger-7"
SENDER, RECEIVER = ("sender", 1), ("receiver", 2)
ONE_WAY_S = 0.04
STEP_S = 0.005
DRAW_STEPS = 8  # 25 images a second
POLL_STEPS = 2  # sound comes and goes in blocks of 10 ms
WINDOW_S = 10.0  # over which --kbps is a promise
HOP, FRAME = 32, 512  # samples: resolution and window of the envelopes that align sounds
BAND_EDGES = np.round(FRAME / SAMPLE_RATE * 150 * 2 ** (np.arange(-1, 31, 2) / 6)).astype(int)  # bins, up to 4.5 kHz
SETTLE_S = 18.0  # before figures count: the loss is known, formats are acknowledged


@dataclass(frozen=True)
class Loss:
    """Random loss of datagrams, both ways. burst : datagrams lost in a row"""

    fraction: float = 0.0
    burst: int = 1


@dataclass
class VoiceCall:
    """What a simulated call measured.

    sent : (time, bytes with headers) of each datagram of the sender after the handshake
    heard : the sound of the receiver, from the time heard_at on
    shown : (time, displacements) of the frame that is due, 25 a second
    errors : of the control points of each received frame, % of the eye distance
    captured_at : capture time of each of these frames
    cpu_s : spent on voice by both ends together
    """

    seconds: float
    sent: list[tuple[float, int]] = field(default_factory=list)
    heard: list[Samples] = field(default_factory=list)
    heard_at: float = 0.0
    shown: list[tuple[float, NDArray[np.float32]]] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    captured_at: list[float] = field(default_factory=list)
    cpu_s: float = 0.0

    @property
    def kbps(self) -> float:
        """Rate of the sender after the start."""
        return sum(size for at, size in self.sent if at >= SETTLE_S) * 8 / (self.seconds - SETTLE_S) / 1000

    @property
    def worst_kbps(self) -> float:
        """Rate of the worst WINDOW_S."""
        times = np.array([at for at, _ in self.sent])
        sizes = np.array([size for _, size in self.sent])
        return max(float(sizes[(times >= at) & (times < at + WINDOW_S)].sum()) for at in times) * 8 / WINDOW_S / 1000


class LoopedSound:
    """A sound that is captured again and again. Blocks of 10 ms, as a device gives them."""

    def __init__(self, samples: Samples) -> None:
        self._samples = samples
        self._position = 0

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return the sound up to a time."""
        end = int(until * SAMPLE_RATE)
        if end <= self._position:
            return []
        block = self._samples[np.arange(self._position, end) % len(self._samples)]
        at, self._position = self._position / SAMPLE_RATE, end
        return [AudioBlock(at, block)]

    def close(self) -> None:
        """Do nothing."""


def call(
    track: Track | None,
    sound: Samples,
    *,
    seconds: float,
    kbps: float | None,
    loss: Loss,
    seed: int,
    voice: VoiceMode = VoiceMode.AUTOMATIC,
    fps: float = 30.0,
    repeats: bool = True,
) -> VoiceCall:
    """Make a call.

    track : motion at `fps`, None for no face; sound : (n,) int16; both are repeated
    kbps : limit of the sender's rate, None for none; repeats : whether lost voice may be repeated
    """
    rng, result = random.Random(seed), VoiceCall(seconds)
    receiver = ReceiverEndpoint(SessionServer(CODE, rng.randbytes))
    parameters = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
    options = RateOptions(kbps=kbps, voice=voice)
    sender = SenderConnection(SenderSession(CODE, RECEIVER, rng.randbytes, -3.0), parameters, -3.0, rate=options)
    if not repeats:
        sender._send.budget._repetition.on_report = lambda *_: None  # type: ignore[method-assign]
    network = _Network(loss, rng)
    mixer = VoiceMixer(receiver.streams, np.random.default_rng(seed))
    output = ClipSound(mixer)
    source = VoiceSender(LoopedSound(sound), VoiceProcessor())
    pacer, next_frame = FramePacer(15.0), 0
    watched = False
    steps = round((seconds + 3.0) / STEP_S)
    for step in range(steps):
        now = step * STEP_S - 3.0
        for data in network.arriving("receiver", now):
            receiver.receive_datagram(data, SENDER, now)
        for data in network.arriving("sender", now):
            sender.receive_datagram(data, RECEIVER, now)
        if now >= 0:
            while track is not None and next_frame / fps <= now:
                frame = track.frames[next_frame % len(track.frames)]
                timestamp, next_frame = next_frame / fps, next_frame + 1
                pacer.fps = sender.outbound.profile.fps
                if pacer.delay_for(timestamp, now) is not None:
                    sender.send_frame(type(frame)(timestamp, frame.displacements, frame.pose), now)
            if step % POLL_STEPS == 0:
                result.cpu_s += _timed(source.poll, now, sender, now)
        for data, _ in sender.datagrams_to_send(now):
            if now >= 0:
                result.sent.append((now, len(data) + HEADER_BYTES))
            network.send("receiver", data, now)
        for data, _ in receiver.datagrams_to_send(now):
            network.send("sender", data, now)
        if now >= 0 and step % POLL_STEPS == 0:
            start = time.process_time()
            blocks = output.recorded(now)
            result.cpu_s += time.process_time() - start
            if blocks and not result.heard:
                result.heard_at = blocks[0].timestamp
            result.heard += [block.samples for block in blocks]
        if now >= 0 and step % DRAW_STEPS == 0:
            due = [stream.motion.frame_at(now) for stream in receiver.streams.values()]
            result.shown += [(now, playout.frame.displacements) for playout in due if playout]
        if track is not None and receiver.streams and not watched:
            watched = True
            watch(receiver.streams, track, fps, result)
    return result


class _Network:
    """Both directions of a link."""

    def __init__(self, loss: Loss, rng: random.Random) -> None:
        self._loss = loss
        self._rng = rng
        self._burst = {"sender": 0, "receiver": 0}
        self._queues: dict[str, list[tuple[float, bytes]]] = {"sender": [], "receiver": []}

    def send(self, to: str, data: bytes, now: float) -> None:
        """Lose a datagram or let it arrive ONE_WAY_S later. The handshake is not disturbed."""
        if now >= 0 and self._is_lost(to):
            return
        self._queues[to].append((now + ONE_WAY_S, data))

    def arriving(self, to: str, now: float) -> list[bytes]:
        """Return what arrives by now."""
        queue = self._queues[to]
        count = next((i for i, (at, _) in enumerate(queue) if at > now), len(queue))
        self._queues[to] = queue[count:]
        return [data for _, data in queue[:count]]

    def _is_lost(self, to: str) -> bool:
        if self._burst[to]:
            self._burst[to] -= 1
            return True
        probability = self._loss.fraction / (self._loss.burst - self._loss.fraction * (self._loss.burst - 1))
        if self._rng.random() < probability:
            self._burst[to] = self._loss.burst - 1
            return True
        return False


def _timed(task: Callable[..., None], *arguments: object) -> float:
    start = time.process_time()
    task(*arguments)
    return time.process_time() - start


def watch(streams: dict[int, ReceiveLeg], track: Track, fps: float, result: VoiceCall) -> None:
    """Compare each frame that the streams receive with the frame captured nearest to its time."""
    for stream in streams.values():
        add = stream.motion.buffer.add

        def compare(frame: MotionFrame, now: float, add: Callable[[MotionFrame, float], None] = add) -> None:
            add(frame, now)
            index = round(frame.timestamp * fps)
            errors = [
                track.image_errors(i % len(track.frames), frame.displacements, frame.pose).mean()
                for i in range(max(index - 1, 0), index + 2)
            ]
            result.errors.append(float(min(errors)))
            result.captured_at.append(frame.timestamp)

        stream.motion.buffer.add = compare  # type: ignore[method-assign]


def align(captured: Sound, heard: Sound, *, max_samples: int) -> int:
    """Return by how many samples `heard` is later than `captured`: within 1 ms, for a vocoder within 3.

    Found as the maximum of the cross-correlation of the envelopes in third-octave bands, the measure of STOI: a vocoder
    does not keep the waveform, whose correlation was wrong by up to 20 ms (STOI .2 too low).
    """
    first, second = _envelopes(captured), _envelopes(heard)
    size = 1 << (len(first) + len(second)).bit_length()
    spectra = np.fft.rfft(second, size, axis=0) * np.conj(np.fft.rfft(first, size, axis=0))
    correlation = np.fft.irfft(spectra.sum(axis=1), size)
    peak = int(np.argmax(correlation[: max_samples // HOP + 1]))
    before, at, after = correlation[[peak - 1, peak, peak + 1]]
    parabola = (before - after) / (before - 2 * at + after) / 2
    return min(max(round((peak + float(parabola)) * HOP), 0), max_samples)


def _envelopes(sound: Sound) -> NDArray[np.float64]:
    """Return (n, len(BAND_EDGES) - 1) amplitudes every HOP samples, each band without its mean and of unit norm."""
    frames = np.lib.stride_tricks.sliding_window_view(sound, FRAME)[::HOP] * np.hanning(FRAME)
    power = np.abs(np.fft.rfft(frames, axis=1)) ** 2
    bands = np.sqrt(np.add.reduceat(power, BAND_EDGES, axis=1)[:, :-1])
    bands -= bands.mean(axis=0)
    return np.asarray(bands / (np.linalg.norm(bands, axis=0) + 1e-9))
