"""What video codecs make of the same frames at a few kbit/s, every packet paid with its headers."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from tools.bench.portrait_clip import FPS, SIZE

HEADERS = 40  # bytes of RTP, UDP and IPv4 a datagram
MTU = 1200
LEAST_BITRATE = 1000

# One key frame at the start, and careful settings. AV1 may even reorder frames, which adds delay that no call would
# bear: made to code them as they come, its pictures are far worse (face SSIM .81, not .89, on grid_swiz3n at 8 kbit/s).
CODECS = {
    "av1": ("libsvtav1", {"preset": "5", "svtav1-params": "rc=1:pred-struct=2:lookahead=0"}),
    "vp9": ("libvpx-vp9", {"deadline": "good", "cpu-used": "3", "lag-in-frames": "0", "undershoot-pct": "0"}),
    "x264": ("libx264", {"preset": "slow", "tune": "zerolatency", "x264-params": "bframes=0:scenecut=0"}),
}
DECODERS = {"libsvtav1": "libdav1d", "libaom-av1": "libdav1d", "libvpx-vp9": "vp9", "libx264": "h264"}


@dataclass(frozen=True)
class Video:
    """Decoded frames, one for each that went in, and what each cost on the wire in bytes."""

    frames: list[NDArray[np.uint8]]
    wire_bytes: list[int]


def transmit(frames: Sequence[NDArray[np.uint8]], codec: str, kbps: float, /) -> Video:
    """Encode frames so that packets and headers together cost about `kbps`, and decode them."""
    name, options = CODECS[codec]
    encoder: Any = av.CodecContext.create(name, "w")
    encoder.width, encoder.height = SIZE
    encoder.pix_fmt = "yuv420p"
    encoder.time_base, encoder.framerate = Fraction(1, FPS), Fraction(FPS)
    encoder.bit_rate = max(LEAST_BITRATE, round(kbps * 1000 - HEADERS * 8 * FPS))
    encoder.gop_size = 10_000
    encoder.options = options
    packets: list[Any] = []
    for number, pixels in enumerate(frames):
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="bgr24")
        frame.pts = number
        packets += encoder.encode(frame)
    packets += encoder.encode(None)
    return Video(_decode(packets, name, len(frames)), _cost(packets, len(frames)))


def _decode(packets: list[Any], encoder: str, count: int) -> list[NDArray[np.uint8]]:
    decoder: Any = av.CodecContext.create(DECODERS[encoder], "r")
    by_time: dict[int, NDArray[np.uint8]] = {}
    for packet in [*packets, None]:
        for frame in decoder.decode(packet):
            by_time[int(frame.pts)] = frame.to_ndarray(format="bgr24")
    shown: list[NDArray[np.uint8]] = []
    for number in range(count):  # a frame that the encoder left out: the one before it stays
        shown.append(by_time.get(number, shown[-1] if shown else np.zeros((SIZE[1], SIZE[0], 3), np.uint8)))
    return shown


def _cost(packets: list[Any], count: int) -> list[int]:
    cost = [0] * count
    for packet in packets:
        cost[int(packet.pts)] += packet.size + HEADERS * -(-packet.size // MTU)
    return cost
