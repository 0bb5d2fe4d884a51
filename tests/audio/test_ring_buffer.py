"""The queue between threads: order, capacity, wrapping; playback that never clicks."""

import sys
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.audio.ring_buffer import CaptureBuffer, PlaybackBuffer, RingBuffer
from tests.support.synthetic_voice import max_jump, tone

operations = st.lists(st.tuples(st.booleans(), st.integers(0, 30)), max_size=60)


@pytest.mark.slow
@given(operations=operations, capacity=st.integers(1, 40))
def test_behaves_as_a_queue_of_limited_length(operations: list[tuple[bool, int]], capacity: int) -> None:
    buffer, model = RingBuffer(capacity), list[int]()
    number = dropped = 0
    for is_write, count in operations:
        if is_write:
            samples = np.arange(number, number + count, dtype=np.int16)
            accepted = min(count, capacity - len(model))
            assert buffer.write(samples) == accepted
            model += samples[:accepted].tolist()
            number, dropped = number + count, dropped + count - accepted
        else:
            expected, model = model[:count], model[count:]
            assert buffer.read(count).tolist() == expected
        assert len(buffer) == len(model) and buffer.dropped == dropped


@pytest.mark.slow
def test_two_threads_lose_nothing() -> None:
    buffer, total = RingBuffer(100), 4000
    numbers = np.arange(total).astype(np.int16)

    def write_all() -> None:
        position = 0
        while position < total:
            count = min(37, 100 - len(buffer), total - position)
            position += buffer.write(numbers[position : position + count])

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    writer = threading.Thread(target=write_all)
    writer.start()
    parts, received = [], 0
    while received < total:
        parts.append(buffer.read(64))
        received += len(parts[-1])
    writer.join()
    sys.setswitchinterval(interval)
    np.testing.assert_array_equal(np.concatenate(parts), numbers)


def test_captured_blocks_keep_their_times() -> None:
    buffer = CaptureBuffer(250)
    blocks = [np.full(100, value, np.int16) for value in (1, 2, 3)]
    for number, block in enumerate(blocks):
        buffer.write_block(block, 0.5 + number)
    read = buffer.read_blocks()
    assert [(set(samples.tolist()), len(samples), end) for samples, end in read] == [({1}, 100, 0.5), ({2}, 100, 1.5)]
    assert buffer.dropped == 100 and buffer.read_blocks() == []


def test_the_fade_of_playback_has_the_same_time_at_every_rate() -> None:
    buffer = PlaybackBuffer(1000, rate=48000)
    buffer.write(np.full(400, 9600, np.int16))
    assert (np.diff(buffer.pull(400)) > 0).sum() == 239


def test_playback_starts_silent_and_fades_in_over_5_ms() -> None:
    buffer = PlaybackBuffer(1600)
    assert not buffer.pull(160).any()
    buffer.write(np.full(320, 8000, np.int16))
    started = buffer.pull(320)
    assert started[:80].tolist() == [100 * i for i in range(1, 81)]
    assert (started[80:] == 8000).all()
    assert buffer.underruns == buffer.missing == 0


def test_an_underrun_is_faded_and_counted_once() -> None:
    buffer = PlaybackBuffer(16000)
    sound = tone(200, 0.5)
    buffer.write(sound[:1000])
    played = [buffer.pull(160) for _ in range(10)]
    buffer.write(sound[1000:2000])
    played += [buffer.pull(160) for _ in range(6)]
    assert max_jump(np.concatenate(played)) < 2 * max_jump(sound)
    assert buffer.underruns == 1
    assert buffer.missing == 600


@pytest.mark.slow
@given(writes=st.lists(st.tuples(st.integers(0, 300), st.integers(0, 300)), max_size=30))
def test_pull_returns_what_was_asked_and_never_clicks(writes: list[tuple[int, int]]) -> None:
    buffer, sound = PlaybackBuffer(20000), tone(150, 1.0)
    position, parts = 0, [np.zeros(1, np.int16)]
    for write, pull in writes:
        buffer.write(sound[position : position + write])
        position += write
        parts.append(buffer.pull(pull))
        assert len(parts[-1]) == pull
    assert max_jump(np.concatenate(parts)) <= max_jump(sound) + 8000 / 80 + 1
