"""From what travels to pixels. Sizes were read and bounded before it comes here."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import inverse_dct, predict_patch, region_points_in_photo
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.patch import Patch, step_size
from conf.protocol.portrait.vp8 import read_frame_size, wrap_riff


def decode_picture(frame: bytes, /) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR. Raises ProtocolError if the bytes are no picture of the size they say."""
    width, height = read_frame_size(frame)
    try:
        pixels = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise ProtocolError("a picture that cannot be decoded") from error
    if pixels is None or pixels.shape != (height, width, 3):
        raise ProtocolError("a picture that cannot be decoded")
    return np.asarray(pixels, dtype=np.uint8)


def reconstruct_patch(patch: Patch, photo: NDArray[np.uint8], warp: PortraitWarp, /) -> NDArray[np.uint8]:
    """Return a patch's picture (h, w, 3) uint8 BGR: the photograph (H, W, 3), moved and corrected.

    Raises ValueError if the patch's points tell no place.
    """
    points = region_points_in_photo(warp, FEATURES[patch.region])
    difference = inverse_dct([plane * step_size(patch.step) for plane in patch.coefficients], patch.size)
    painted = predict_patch(photo, points, patch.points, patch.size) + difference
    return np.asarray(np.clip(np.rint(painted), 0, 255), dtype=np.uint8)
