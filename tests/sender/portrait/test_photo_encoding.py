import numpy as np

from conf.protocol.portrait.vp8 import read_frame_size
from conf.sender.portrait.photo_encoding import decode_vp8, encode_vp8
from tests.support.drawn_person import draw_person


def test_a_frame_keeps_to_its_bytes_and_more_bytes_give_a_better_image() -> None:
    noisy = draw_person().astype(float) + np.random.default_rng(0).normal(0, 12, (240, 320, 3))
    pixels = np.clip(noisy, 0, 255).astype(np.uint8)
    errors = []
    for max_bytes in (2000, 4000, 8000):
        frame = encode_vp8(pixels, max_bytes=max_bytes)
        assert len(frame) <= max_bytes and read_frame_size(frame) == (320, 240)
        errors.append(float(np.abs(decode_vp8(frame).astype(float) - pixels).mean()))
    assert errors == sorted(errors, reverse=True)


def test_too_few_bytes_give_the_smallest_frame() -> None:
    assert read_frame_size(encode_vp8(draw_person(), max_bytes=10)) == (320, 240)
