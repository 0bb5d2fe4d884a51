"""Encode images as bare VP8 frames within a number of bytes, and decode them."""

import io

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from conf.protocol.portrait.vp8 import strip_riff, wrap_riff

MAX_QUALITY = 92  # of 100; higher ones gain nothing visible
_TRIES = 5  # bisection steps over the quality, to within 3; 5 ms each


def encode_vp8(pixels: NDArray[np.uint8], /, *, max_bytes: int) -> bytes:
    """Return the VP8 frame of an image (H, W, 3) uint8 BGR, at most `max_bytes` if any quality gives that."""
    image = Image.fromarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB))
    low, high = 0, MAX_QUALITY
    best: bytes | None = None
    for _ in range(_TRIES):
        quality = (low + high + 1) // 2
        frame = _encode(image, quality)
        if len(frame) <= max_bytes:
            best, low = frame, quality
        else:
            high = quality - 1
        if low >= high:
            break
    return _encode(image, 0) if best is None else best


def _encode(image: Image.Image, quality: int) -> bytes:
    file = io.BytesIO()
    image.save(file, "WEBP", quality=quality, method=6)
    return strip_riff(file.getvalue())


def decode_vp8(frame: bytes, /) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) uint8 BGR of one of our own VP8 frames, as the receiver decodes it."""
    pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    assert pixels is not None, "encode_vp8 made this frame"
    return np.asarray(pixels, dtype=np.uint8)
