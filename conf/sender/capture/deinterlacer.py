"""Deinterlace decoded frames. Source: FFmpeg's filter bwdif."""

from collections.abc import Iterator
from typing import Any

import av
import av.error
import av.filter

_Format = tuple[str, int, int]


class Deinterlacer:
    """Passes progressive frames through until the first interlaced one comes; then a filter graph sees all frames.

    The graph is built anew when the size or the pixel format changes. Frames that the filter cannot treat, such as
    those of fewer than three rows, pass as they are.
    """

    def __init__(self, stream: Any) -> None:
        """stream : PyAV's video stream that the frames come from"""
        self._stream = stream
        self._graph: av.filter.Graph | None = None
        self._format: _Format | None = None

    def push(self, frame: Any, /) -> Iterator[Any]:
        """Yield the frames that are ready, one for each frame, at the time of its first field. None flushes."""
        if frame is None:
            yield from self._flush()
            return
        format_ = (frame.format.name, frame.width, frame.height)
        if format_ != self._format:
            yield from self._flush()
            self._format = format_
        if self._graph is None and frame.interlaced_frame:
            self._graph = self._build(format_)
        if self._graph is None:
            yield frame
            return
        self._graph.push(frame)
        yield from self._pull()

    def _build(self, format_: _Format) -> av.filter.Graph | None:
        name, width, height = format_
        graph = av.filter.Graph()
        try:
            source = graph.add_buffer(
                format=av.VideoFormat(name, width, height), width=width, height=height, time_base=self._stream.time_base
            )
            filter_ = graph.add("bwdif", "mode=send_frame:parity=auto:deint=interlaced")
            sink = graph.add("buffersink")
            source.link_to(filter_)
            filter_.link_to(sink)
            graph.configure()
        except (av.error.FFmpegError, ValueError):
            return None
        return graph

    def _flush(self) -> Iterator[Any]:
        if self._graph is not None:
            self._graph.push(None)
            yield from self._pull()
        self._graph = None

    def _pull(self) -> Iterator[Any]:
        while self._graph is not None:
            try:
                yield self._graph.pull()
            except (av.error.BlockingIOError, av.error.EOFError):
                return
