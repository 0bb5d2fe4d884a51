"""Simulate a call to measure the codec: code every frame of a track, send it over a lossy link, decode, compare.

Definition of the error: the codec codes the smoothed motion that the sender extracts from a track. For every decoded
frame the 50 control points, original and decoded, are added to the mean face with the person's FAPU and projected with
the original and the decoded pose. Their distance in the image is divided by the distance of the outer eye corners
(landmarks 33 and 263) in that frame. Mean and 95th percentile are over points and frames.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.profiles import Profile
from conf.protocol.codec.reference_frames import MissingReferenceError
from conf.protocol.statistics import HEADER_BYTES
from tools.bench.tracks import Track

# Every fifth file: not used to train the shipped tables.
HELD_OUT = ("grid_lbax4n", "man_smiles", "talk_1", "talk_4", "talk_9")

FRAMING_BYTES = 15  # framing and seal of a datagram 14, message kind and frame number 1


@dataclass(frozen=True)
class Link:
    """Properties of the simulated link.

    ack_delay : ticks from a frame to the arrival of its acknowledgement, 0 for never
    loss : probability of losing a datagram or an acknowledgement
    seed : random seed of the losses
    """

    ack_delay: int = 2
    loss: float = 0.0
    seed: int = 0


@dataclass(frozen=True)
class Result:
    """Measured figures.

    frames_recovered : frames decoded although an earlier one was lost
    errors : (frames played, n) per cent of the eye distance
    times : seconds to encode and decode each payload
    """

    fps: float
    frames: int
    frames_lost: int
    frames_recovered: int
    payload_bytes: int
    datagrams: int
    errors: NDArray[np.float64]
    times: NDArray[np.float64]

    @property
    def wire_bytes(self) -> int:
        """Return the bytes of all datagrams with their headers."""
        return self.payload_bytes + self.datagrams * (HEADER_BYTES + FRAMING_BYTES)

    @property
    def payload_bytes_per_frame(self) -> float:
        """Return the bytes of the codec's payload a frame, without headers."""
        return self.payload_bytes / self.frames

    @property
    def kbps(self) -> float:
        """Return kilobits a second, headers included."""
        return self.wire_bytes * 8 / (self.frames / self.fps) / 1000

    @property
    def error_mean_percent(self) -> float:
        """Return the mean over points and frames."""
        return float(self.errors.mean()) if self.errors.size else float("nan")

    @property
    def error_p95_percent(self) -> float:
        """Return the 95th percentile over points and frames."""
        return float(np.percentile(self.errors, 95)) if self.errors.size else float("nan")

    def summary(self) -> dict[str, float]:
        """Return the figures under the names that --json prints."""
        return {
            "payload_bytes_per_frame": self.payload_bytes_per_frame,
            "wire_bytes_per_frame": self.wire_bytes / self.frames,
            "kbps": self.kbps,
            "error_mean_percent": self.error_mean_percent,
            "error_p95_percent": self.error_p95_percent,
            "frames_played": len(self.errors),
            "frames_lost": self.frames_lost,
            "frames_recovered": self.frames_recovered,
            "encode_decode_ms": float(np.median(self.times)) * 1000 * self.datagrams / self.frames,
        }


def total(results: Sequence[Result], /) -> Result:
    """Return the results of several tracks as one."""
    return Result(
        fps=results[0].fps,
        frames=sum(result.frames for result in results),
        frames_lost=sum(result.frames_lost for result in results),
        frames_recovered=sum(result.frames_recovered for result in results),
        payload_bytes=sum(result.payload_bytes for result in results),
        datagrams=sum(result.datagrams for result in results),
        errors=np.concatenate([result.errors for result in results]),
        times=np.concatenate([result.times for result in results]),
    )


def measure(track: Track, profile: Profile, link: Link, /, *, models: Mapping[str, CodecModel] | None = None) -> Result:
    """Send a track through the codec over a link. The last datagram may hold fewer frames than the profile's."""
    random = np.random.default_rng(link.seed)
    encoder, decoder = Encoder(profile, models), Decoder(models)
    acknowledged: dict[int, list[int]] = {}  # frame numbers by the tick at which their acknowledgement arrives
    sizes, errors, times = [], [], []
    lost = recovered = 0
    for number in range(0, len(track.frames), profile.frames_per_datagram):
        for tick in [tick for tick in acknowledged if tick <= number]:
            encoder.acknowledge(acknowledged.pop(tick))
        frames = track.frames[number : number + profile.frames_per_datagram]
        start = time.perf_counter()
        payload = encoder.encode(frames, number)
        encoded = time.perf_counter() - start
        sizes.append(len(payload))
        if random.random() < link.loss:
            lost += len(frames)
            continue
        start = time.perf_counter()
        try:
            decoded = decoder.decode(payload, number)
        except MissingReferenceError:
            lost += len(frames)
            continue
        times.append(encoded + time.perf_counter() - start)
        recovered += len(decoded) if lost else 0
        for frame in decoded:
            errors.append(track.image_errors(frame.frame_number, frame.displacements, frame.pose))
        if link.ack_delay and random.random() >= link.loss:
            arrival = decoded[-1].frame_number + link.ack_delay
            acknowledged.setdefault(arrival, []).extend(frame.frame_number for frame in decoded)
    return Result(
        fps=profile.fps,
        frames=len(track.frames),
        frames_lost=lost,
        frames_recovered=recovered,
        payload_bytes=sum(sizes),
        datagrams=len(sizes),
        errors=np.array(errors).reshape(len(errors), -1),
        times=np.array(times),
    )
