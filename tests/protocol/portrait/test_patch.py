from dataclasses import replace

import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.portrait.patch import decode_patch, encode_patch
from conf.protocol.portrait.vp8 import strip
from tests.protocol.portrait.pictures import patch, webp


def test_a_patch_survives() -> None:
    sent = patch()
    got = decode_patch(encode_patch(sent))
    np.testing.assert_array_equal(got.keys, sent.keys)
    np.testing.assert_allclose(got.points, sent.points, atol=0.005)
    assert (got.photograph, got.region, got.slot, got.frame) == (1, 0, 3, sent.frame)


def test_wrong_patches_are_refused() -> None:
    for wrong in (
        replace(patch(), region=9),
        replace(patch(), slot=200),
        replace(patch(), points=np.zeros((2, 2))),
        replace(patch(), frame=strip(webp(300, 20))),
    ):
        with pytest.raises(ProtocolError):
            decode_patch(encode_patch(wrong))
    with pytest.raises(ProtocolError, match="cut off"):
        decode_patch(b"\0\0")
