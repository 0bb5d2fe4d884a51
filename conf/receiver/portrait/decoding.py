"""Decode received photos and patches to pixels. Their sizes have been checked before."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import inverse_dct, predict_patch, region_points_in_photo
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.patch import Patch, step_size
from conf.protocol.portrait.vp8 import read_frame_size, wrap_riff


def decode_image(frame: bytes, /) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR. Raises ProtocolError if the bytes are no VP8 frame of the size in its header."""
    width, height = read_frame_size(frame)
    try:
        pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise ProtocolError("an image that cannot be decoded") from error
    if pixels is None or pixels.shape != (height, width, 3):
        raise ProtocolError("an image that cannot be decoded")
    return np.asarray(pixels, dtype=np.uint8)


def reconstruct_patch(patch: Patch, photo: NDArray[np.uint8], warp: PortraitWarp, /) -> NDArray[np.uint8]:
    """Return a patch's pixels (h, w, 3) uint8 BGR: its prediction from the photo (H, W, 3) plus its residual.

    Raises ValueError if the patch's points coincide.
    """
    points = region_points_in_photo(warp, FEATURES[patch.region])
    residual = inverse_dct([plane * step_size(patch.step) for plane in patch.coefficients], patch.size)
    pixels = predict_patch(photo, points, patch.points, patch.size) + residual
    return np.asarray(np.clip(np.rint(pixels), 0, 255), dtype=np.uint8)
