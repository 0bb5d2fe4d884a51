import numpy as np
import pytest

from conf.sender.tracking.tracker import TrackedFace
from tools.bench.portrait_clip import START_S, unlooped
from tools.bench.portrait_faults import LIDS, artefact_fractions, lid_distances

GREY = np.full((240, 320, 3), 120, np.uint8)


def tracked(gap: float = 10.0) -> TrackedFace:
    """Return a face of 100 x 100 px in the middle, whose lids are `gap` px apart."""
    landmarks = np.zeros((478, 3), np.float32)
    landmarks[:, :2] = np.random.default_rng(1).uniform((110, 70), (210, 170), (478, 2))
    landmarks[:4, :2] = (110, 70), (210, 70), (110, 170), (210, 170)
    for (upper, lower), left in zip(LIDS, (120, 170), strict=True):
        x = np.linspace(left, left + 30, len(upper))
        landmarks[list(lower), :2] = np.column_stack([x, np.full(len(x), 100.0)])
        landmarks[list(upper)[1:-1], :2] = np.column_stack([x, np.full(len(x), 100.0 - gap)])[1:-1]
    return TrackedFace(landmarks, np.zeros(52, np.float32), 1.0)


def test_what_was_never_filmed_at_a_position_is_an_artefact() -> None:
    spot = GREY.copy()
    spot[:60, :80] = 250
    sources = [GREY, GREY, GREY, GREY]
    fractions = artefact_fractions(sources, [spot, None, GREY, GREY], [tracked(), tracked(), None, tracked()])
    assert fractions[1:] == [None, None, 0.0]
    assert fractions[0] == pytest.approx(60 * 80 / (320 * 240 - 100 * 100), abs=0.005)


def test_an_earlier_frame_excuses_what_is_shown_and_the_face_does_not_count() -> None:
    spot, face = GREY.copy(), GREY.copy()
    spot[:60, :80] = 250
    face[80:160, 120:200] = 0
    assert artefact_fractions([spot, GREY, GREY], [GREY, spot, face], [tracked()] * 3)[1:] == [0.0, 0.0]


def test_only_shut_lids_are_compared() -> None:
    blue = GREY.copy()
    blue[..., 0] += 90
    trackings = [tracked(), tracked(), tracked(1.0), None, tracked(1.0)]
    distances = lid_distances([GREY] * 5, [blue, blue, blue, blue, None], trackings)
    assert [d is None for d in distances] == [True, True, False, True, True]
    assert distances[2] == pytest.approx(90 / np.sqrt(3), abs=1)


def test_after_the_start_each_frame_of_an_unlooped_clip_comes_once() -> None:
    frames = [np.full((2, 2, 3), i, np.uint8) for i in range(100)]
    shown = [int(frame[0, 0, 0]) for frame in unlooped(frames)]
    start = round(START_S * 15)
    assert shown[start - 2 :] == list(range(48, 100)) and max(shown[:start]) == 49
    long = frames * 5
    assert unlooped(long) == long
