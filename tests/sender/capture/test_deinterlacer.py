from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import av
import numpy as np
import pytest

from conf.sender.capture.deinterlacer import Deinterlacer

STREAM = SimpleNamespace(time_base=Fraction(1, 25))


def frame(number: int, *, size: tuple[int, int] = (16, 12), format_: str = "yuv420p") -> Any:
    pixels = np.full((size[1], size[0], 3), 10 * number, np.uint8)
    made = av.VideoFrame.from_ndarray(pixels, format="bgr24").reformat(format=format_)
    made.pts, made.time_base = number, STREAM.time_base
    return made


def interlaced_frames(count: int, **options: Any) -> list[Any]:
    """Return frames that a filter has marked as interlaced."""
    graph = av.filter.Graph()
    first = frame(0, **options)
    source = graph.add_buffer(width=first.width, height=first.height, format=first.format, time_base=STREAM.time_base)
    mark, sink = graph.add("setfield", "tff"), graph.add("buffersink")
    source.link_to(mark)
    mark.link_to(sink)
    graph.configure()
    frames: list[Any] = []
    for number in range(count):
        graph.push(frame(number, **options))
        frames.append(graph.pull())
    assert all(one.interlaced_frame for one in frames)
    return frames


def run(frames: list[Any]) -> list[Any]:
    deinterlacer = Deinterlacer(STREAM)
    return [out for one in [*frames, None] for out in deinterlacer.push(one)]


def test_progressive_frames_pass_untouched() -> None:
    frames = [frame(i) for i in range(3)]
    assert all(a is b for a, b in zip(run(frames), frames, strict=True))


def test_each_interlaced_frame_gives_one_frame_at_its_time() -> None:
    out = run(interlaced_frames(5))
    assert [one.time for one in out] == pytest.approx([i / 25 for i in range(5)])
    assert not any(one.interlaced_frame for one in out)


def test_another_size_or_format_starts_a_new_filter() -> None:
    frames = interlaced_frames(3) + interlaced_frames(2, size=(32, 24)) + interlaced_frames(2, format_="yuv422p")
    assert [(one.width, one.format.name) for one in run(frames)] == (
        [(16, "yuv420p")] * 3 + [(32, "yuv420p")] * 2 + [(16, "yuv422p")] * 2
    )


@pytest.mark.parametrize("options", [{"size": (16, 2)}, {"size": (2, 2)}, {"format_": "rgb24"}, {"format_": "nv12"}])
def test_what_the_filter_cannot_treat_passes(options: dict[str, Any]) -> None:
    assert len(run(interlaced_frames(3, **options))) == 3
