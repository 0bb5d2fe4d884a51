"""From the bare VP8 frames that travel to pixels. Their size was read and bounded before they come here."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.portrait.vp8 import size_of, wrap


def decode_picture(frame: bytes, /) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR. Raises ProtocolError if the bytes are no picture of the size they say."""
    width, height = size_of(frame)
    try:
        pixels = cv2.imdecode(np.frombuffer(wrap(frame), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise ProtocolError("a picture that cannot be decoded") from error
    if pixels is None or pixels.shape != (height, width, 3):
        raise ProtocolError("a picture that cannot be decoded")
    return np.asarray(pixels, dtype=np.uint8)
