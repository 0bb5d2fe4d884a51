import numpy as np

from conf.sender.capture.frame import Frame

PIXELS = np.zeros((4, 6, 3), np.uint8)


def test_an_image_is_made_once_and_only_if_somebody_asks() -> None:
    made = []

    def make() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        made.append(True)
        return PIXELS

    frame = Frame(make, 1.5)
    assert (frame.timestamp, made) == (1.5, [])
    assert frame.pixels is PIXELS is frame.pixels and len(made) == 1
    assert Frame(PIXELS, 0.0).pixels is PIXELS
