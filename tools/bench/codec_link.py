"""A simulated call for measuring the codec: every frame of a track coded, sent over a lossy link, decoded, compared.

What the errors are. The codec is given the smoothed motion that the sender makes of a track. Of every frame that is
shown, the 50 control points as given and as decoded are put on the mean face with the person's FAPU, turned, moved and
scaled by the given and the decoded pose, and their distance in the picture is divided by the distance of the outer eye
corners (landmarks 33 and 263) in that frame. The mean is over points and frames, the 95th percentile too.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec import Decoder, Encoder, MissingReferenceError, Profile
from conf.protocol.codec.model import CodecModel
from conf.protocol.statistics import HEADER_BYTES
from tools.bench.tracks import Track

HELD_OUT = ("grid_lbax4n", "man_smiles", "talk_1", "talk_4", "talk_9")  # every fifth file: not in the shipped tables

FRAMING_BYTES = 15  # framing and seal of a datagram 14, and the byte that says motion and its number


@dataclass(frozen=True)
class Link:
    """How frames and acknowledgements travel.

    ack_delay : ticks after a frame that its acknowledgement is there, 0 for never
    loss : share of datagrams, and of acknowledgements, that are lost
    seed : of the losses
    """

    ack_delay: int = 2
    loss: float = 0.0
    seed: int = 0


@dataclass(frozen=True)
class Result:
    """What was measured.

    frames_recovered : decoded although a frame before was lost
    errors : (frames played, n) per cent of the eye distance
    times : seconds to encode and decode each payload
    """

    fps: int
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
        """Return the codec's bytes."""
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
        """Return the figures by the names that --json prints."""
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
    """Send a track through the codec over a link. The last frames, if they fill no bundle, make a shorter one."""
    random = np.random.default_rng(link.seed)
    encoder, decoder = Encoder(profile, models), Decoder(models)
    acknowledged: dict[int, list[int]] = {}  # numbers by the tick at which the sender hears of them
    sizes, errors, times = [], [], []
    lost = recovered = 0
    for number in range(0, len(track.frames), profile.frames_per_datagram):
        for tick in [tick for tick in acknowledged if tick <= number]:
            encoder.acknowledge(acknowledged.pop(tick))
        frames = track.frames[number : number + profile.frames_per_datagram]
        began = time.perf_counter()
        payload = encoder.encode(frames, number)
        encoded = time.perf_counter() - began
        sizes.append(len(payload))
        if random.random() < link.loss:
            lost += len(frames)
            continue
        began = time.perf_counter()
        try:
            decoded = decoder.decode(payload, number)
        except MissingReferenceError:
            lost += len(frames)
            continue
        times.append(encoded + time.perf_counter() - began)
        recovered += len(decoded) if lost else 0
        for frame in decoded:
            errors.append(track.picture_errors(frame.frame_number, frame.displacements, frame.pose))
        if link.ack_delay and random.random() >= link.loss:
            heard = decoded[-1].frame_number + link.ack_delay
            acknowledged.setdefault(heard, []).extend(frame.frame_number for frame in decoded)
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
