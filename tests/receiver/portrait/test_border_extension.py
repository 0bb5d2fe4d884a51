import numpy as np

from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.receiver.portrait.border_extension import extend_border


def test_the_picture_stays_and_its_colours_go_on_softer_the_farther_out() -> None:
    colours = np.zeros((80, 120, 3), np.uint8)
    colours[:, ::8] = 200
    share = np.full((80, 120), 255, np.uint8)
    drawn, drawn_share, margin = extend_border(colours, share)
    across, up = np.rint(margin * (120, 80)).astype(int)
    assert across == up == np.ceil(BORDER_EXTENSION * 80) and drawn.shape == (80 + 2 * up, 120 + 2 * across, 3)
    np.testing.assert_array_equal(drawn[up:-up, across:-across], colours)
    near, far = drawn[up - 1, across:-across, 0].astype(float), drawn[2, across:-across, 0].astype(float)
    assert near.std() < colours[0, :, 0].std() and far.std() < 0.2 * near.std() + 5
    assert 10 < far.mean() < 60 and (drawn_share == 255).all()


def test_beside_a_person_there_is_none_of_him() -> None:
    share = np.zeros((80, 120), np.uint8)
    share[:, :30] = 255
    _, drawn, margin = extend_border(np.zeros((80, 120, 3), np.uint8), share)
    up = round(float(margin[1]) * 80)
    assert drawn[up - 2, up + 5] > 200 and drawn[up - 2, -up - 20] < 20
