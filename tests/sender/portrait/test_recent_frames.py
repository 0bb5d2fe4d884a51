import numpy as np

from conf.sender.portrait.recent_frames import (
    AVERAGED,
    MAX_FRAMES,
    MAX_PENALTY,
    SAMPLE_INTERVAL_S,
    RecentFrames,
    evenly_spaced,
    nearest,
    reduce_height,
)
from tests.support.portrait_subjects import captured_face, motion

PIXELS = np.zeros((12, 16, 3), np.uint8)
FACE = captured_face(PIXELS)


def sampled(penalties: list[float]) -> RecentFrames:
    frames = RecentFrames(12)
    for number, penalty in enumerate(penalties):
        frames.sample(FACE, motion(), penalty, number * SAMPLE_INTERVAL_S * 1.01)
    return frames


def test_frames_are_sampled_at_intervals_and_the_oldest_are_dropped() -> None:
    frames = RecentFrames(12)
    for step in range(10):
        frames.sample(FACE, motion(), 0.0, step * SAMPLE_INTERVAL_S / 4)
    assert len(frames.like(0.0)) == 3
    many = sampled([float(i) / 1e6 for i in range(MAX_FRAMES + 5)])
    assert len(many.like(0.0)) == MAX_FRAMES
    assert many.like(0.0)[0].penalty == 5 / 1e6


def test_frames_with_a_covered_face_are_left_out() -> None:
    frames = sampled([0.0, MAX_PENALTY + 0.5, 1.0])
    assert [frame.penalty for frame in frames.like(0.0)] == [0.0, 1.0] == [f.penalty for f in frames.clear_ones()]
    assert len(frames.like(1.0)) == 3
    frames.clear()
    assert not frames.clear_ones()


def test_at_most_so_many_frames_are_averaged() -> None:
    frames = sampled([i / 1e6 for i in range(2 * AVERAGED + 1)]).like(0.0)
    spaced = evenly_spaced(frames)
    assert 2 <= len(spaced) <= AVERAGED and spaced[-1] is frames[-1]
    assert [f.penalty for f in spaced] == sorted(f.penalty for f in spaced)
    assert nearest(frames) == frames[:AVERAGED] and not evenly_spaced([])


def test_large_frames_are_reduced() -> None:
    assert reduce_height(np.zeros((480, 640, 3), np.uint8), 240).shape == (240, 320, 3)
    assert reduce_height(PIXELS, 240) is PIXELS


def test_the_last_frame_is_offered_even_between_two_samples_and_landmarks_shrink_with_the_frame() -> None:
    frames = RecentFrames(6)
    assert not frames.all_and_last()
    for step in range(3):
        frames.sample(FACE, motion(), float(step), step * SAMPLE_INTERVAL_S / 4)
    assert [frame.penalty for frame in frames.all_and_last()] == [0.0, 2.0]
    (first, _) = frames.all_and_last()
    assert first.pixels.shape == (6, 8, 3) and np.allclose(first.landmarks, FACE.landmarks / 2)
    frames.sample(FACE, motion(), 3.0, SAMPLE_INTERVAL_S)
    assert [frame.penalty for frame in frames.all_and_last()] == [0.0, 3.0]
    frames.clear()
    assert not frames.all_and_last()
