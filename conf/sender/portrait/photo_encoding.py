"""Pixels to the bare VP8 frames that travel, as good as a number of bytes allows, and back."""

import io

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from conf.protocol.portrait.vp8 import strip_riff, wrap_riff

_TRIES = 5  # of halving the range of qualities: to within three; each takes 5 ms


def encode_vp8(pixels: NDArray[np.uint8], /, *, max_bytes: int, max_quality: int = 92) -> bytes:
    """Return the VP8 frame of a picture (H, W, 3) uint8 BGR, at most `budget` bytes if any quality gives that.

    best : the quality, 0 to 100, beyond which nothing is gained
    """
    image = Image.fromarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB))
    low, high = 0, max_quality
    found: bytes | None = None
    for _ in range(_TRIES):
        quality = (low + high + 1) // 2
        frame = _encode(image, quality)
        if len(frame) <= max_bytes:
            found, low = frame, quality
        else:
            high = quality - 1
        if low >= high:
            break
    return _encode(image, 0) if found is None else found


def _encode(image: Image.Image, quality: int) -> bytes:
    file = io.BytesIO()
    image.save(file, "WEBP", quality=quality, method=6)
    return strip_riff(file.getvalue())


def decode_vp8(frame: bytes, /) -> NDArray[np.uint8]:
    """Return a VP8 frame as the receiver will see it, (H, W, 3) uint8 BGR."""
    pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    assert pixels is not None, "the sender made this picture"
    return np.asarray(pixels, dtype=np.uint8)
