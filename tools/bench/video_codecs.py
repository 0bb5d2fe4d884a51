"""Encode and decode frames with video codecs at a few kbit/s, headers of every packet included."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from tools.bench.portrait_clip import FPS, SIZE

HEADERS = 40  # RTP, UDP and IPv4, bytes a datagram
MTU = 1200
MIN_BITRATE = 1000

# One key frame at the start, and slow presets of high quality. AV1 may reorder frames, which adds more delay than a
# call allows: without reordering its quality is much lower (face SSIM 0.81 instead of 0.89 on grid_swiz3n at 8 kbit/s).
CODECS = {
    "av1": ("libsvtav1", {"preset": "5", "svtav1-params": "rc=1:pred-struct=2:lookahead=0"}),
    "vp9": ("libvpx-vp9", {"deadline": "good", "cpu-used": "3", "lag-in-frames": "0", "undershoot-pct": "0"}),
    "x264": ("libx264", {"preset": "slow", "tune": "zerolatency", "x264-params": "bframes=0:scenecut=0"}),
}
DECODERS = {"libsvtav1": "libdav1d", "libaom-av1": "libdav1d", "libvpx-vp9": "vp9", "libx264": "h264"}


@dataclass(frozen=True)
class Video:
    """One decoded frame for each source frame, and the bytes of each on the wire."""

    frames: list[NDArray[np.uint8]]
    wire_bytes: list[int]


def transmit(frames: Sequence[NDArray[np.uint8]], codec: str, kbps: float, /) -> Video:
    """Encode frames at about `kbps` including headers, and decode them."""
    name, options = CODECS[codec]
    encoder: Any = av.CodecContext.create(name, "w")
    encoder.width, encoder.height = SIZE
    encoder.pix_fmt = "yuv420p"
    encoder.time_base, encoder.framerate = Fraction(1, FPS), Fraction(FPS)
    encoder.bit_rate = max(MIN_BITRATE, round(kbps * 1000 - HEADERS * 8 * FPS))
    encoder.gop_size = 10_000
    encoder.options = options
    packets: list[Any] = []
    for number, pixels in enumerate(frames):
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="bgr24")
        frame.pts = number
        packets += encoder.encode(frame)
    packets += encoder.encode(None)
    return Video(_decode(packets, name, len(frames)), _wire_bytes(packets, len(frames)))


def _decode(packets: list[Any], encoder: str, count: int) -> list[NDArray[np.uint8]]:
    decoder: Any = av.CodecContext.create(DECODERS[encoder], "r")
    by_time: dict[int, NDArray[np.uint8]] = {}
    for packet in [*packets, None]:
        for frame in decoder.decode(packet):
            by_time[int(frame.pts)] = frame.to_ndarray(format="bgr24")
    shown: list[NDArray[np.uint8]] = []
    for number in range(count):  # where the encoder skipped a frame, the previous one is repeated
        shown.append(by_time.get(number, shown[-1] if shown else np.zeros((SIZE[1], SIZE[0], 3), np.uint8)))
    return shown


def _wire_bytes(packets: list[Any], count: int) -> list[int]:
    result = [0] * count
    for packet in packets:
        result[int(packet.pts)] += packet.size + HEADERS * -(-packet.size // MTU)
    return result
