import cv2
import numpy as np

from conf.protocol.portrait.vp8 import read_frame_size, wrap_riff
from conf.sender.portrait.photo_encoding import encode_vp8
from tests.support.drawn_person import draw_person


def test_the_picture_keeps_to_its_budget_and_is_as_good_as_that_allows() -> None:
    noisy = draw_person().astype(float) + np.random.default_rng(0).normal(0, 12, (240, 320, 3))
    pixels = np.clip(noisy, 0, 255).astype(np.uint8)
    errors = []
    for budget in (2000, 4000, 8000):
        frame = encode_vp8(pixels, max_bytes=budget)
        assert len(frame) <= budget and read_frame_size(frame) == (320, 240)
        shown = cv2.imdecode(np.frombuffer(wrap_riff(frame), np.uint8), cv2.IMREAD_COLOR)
        errors.append(float(np.abs(shown.astype(float) - pixels).mean()))
    assert errors == sorted(errors, reverse=True)


def test_a_budget_that_is_too_small_gives_the_smallest_picture() -> None:
    assert read_frame_size(encode_vp8(draw_person(), max_bytes=10)) == (320, 240)
