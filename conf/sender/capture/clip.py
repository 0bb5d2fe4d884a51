"""Read clips with PyAV (FFmpeg): frames with their own times, upright, with square pixels, progressive, 8-bit BGR.

Strategy. The container is opened through a Python file object, never by name: FFmpeg would take the front of
`12:30.mp4` for a protocol, and native code dies on names that are not UTF-8. A decoded frame goes through at most four
steps: deinterlacing (a filter graph that is built when the first interlaced frame comes), conversion to BGR with the
pixel aspect ratio applied, rotation by the display matrix, and a check of its time. Only frames that a decoder has
returned without a corruption flag are used.
"""

import contextlib
import glob
import math
import os
import re
import stat
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import av
import av.error
import av.logging
import av.video.reformatter
import numpy as np
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.sender.capture.allocator import keep_freed_memory
from conf.sender.capture.deinterlacer import Deinterlacer
from conf.sender.capture.frame import Frame
from conf.sender.capture.geometry import fit_into, square_pixel_size, turn_by_matrix
from conf.sender.capture.mp4_index import claims_more_than_it_holds
from conf.sender.capture.presentation_time import PlausibleTime, TimestampChoice

DEFAULT_FPS = 25.0  # of files without a frame rate
MAX_FPS = 1000.0  # of high-speed cameras
MAX_PIXELS = 8192 * 4608  # of a coded picture; more is refused before memory is allocated
# Of a coded picture: up to this one thread decodes in time. Several take 1.3 times its CPU time together.
MAX_SINGLE_THREAD_PIXELS = 1280 * 720
MAX_BAD_PACKETS = 300  # damaged packets in a row before reading ends
SOUND_RATE = 48000
MAX_SOUND_GAP_S = 0.05  # a longer one between two decoded blocks is a gap in the sound, not rounding
_PATTERN_FPS = "25"
_PATTERN = re.compile(r"%0?\d*d")
_DECODER_OPTIONS = {"max_pixels": str(MAX_PIXELS)}
_CLIP_ERRORS = (av.error.FFmpegError, ValueError, OSError, EOFError)  # what PyAV raises on damaged files


@dataclass(frozen=True)
class Round:
    """One pass through a looped clip. start : time of its first frame, s; offset : this plus a time of the file"""

    number: int
    start: float
    offset: float


class Clip:
    """A video file, or a row of pictures named by a pattern.

    fps : mean frames a second, as the container states it
    size : width and height of the frames in pixels, upright and with square pixels
    frame_count : how many frames there are, or None if the container does not say
    round : the pass through the file that the newest frame belongs to
    """

    is_live = False

    def __init__(self, name: str, *, loop: bool = False, turns: int = 0, is_paced: bool = False) -> None:
        """Open a clip and decode its first frame. The parameters are those of `open_clip`. Raises CameraError."""
        self._name = name
        self._loop = loop
        self._turns = turns
        self._is_paced = is_paced
        self._decoder = _Decoder(name, turns, is_paced)
        self._frames = self._decoder.frames()
        self._first = next(self._frames, None)
        if self._first is None:
            self._decoder.close()
            advice = "it may be damaged or end too early; copy it again or convert it."
            raise CameraError(f"{name} has no frame that can be decoded: {advice}")
        self.fps = self._decoder.fps
        self.frame_count = self._decoder.frame_count
        self.size: tuple[int, int] = (self._first.pixels.shape[1], self._first.pixels.shape[0])
        self._times = PlausibleTime(self._first.timestamp)
        self.round = Round(0, 0.0, self._times.offset)

    def read(self) -> Frame | None:
        """Return the next frame, or None at the end. Timestamps are seconds from the first frame and never fall."""
        frame, self._first = self._first, None
        if frame is None:
            frame = next(self._frames, None)
        if frame is None:
            frame = self._rewind()
        if frame is None:
            return None
        return Frame(partial(_fitted, frame, self.size), self._times.of(frame.timestamp, self.fps))

    def release(self) -> None:
        """Do nothing: a clip stays open until it is closed."""

    def close(self) -> None:
        """Close the file."""
        self._frames.close()
        self._decoder.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _rewind(self) -> Frame | None:
        """Start again by opening the file anew: seeking to the start is not exact in every container."""
        if not self._loop or self._times.last is None:
            return None
        self.close()
        self._decoder = _Decoder(self._name, self._turns, self._is_paced)
        self._frames = self._decoder.frames()
        frame = next(self._frames, None)
        if frame is not None:
            start = self._times.last + 1 / self.fps
            self._times.restart(frame.timestamp, start)
            self.round = Round(self.round.number + 1, start, self._times.offset)
        return frame


class _Decoder:
    """The video stream of one opened file."""

    def __init__(self, name: str, turns: int, is_paced: bool) -> None:
        keep_freed_memory()
        self._name = name
        self._turns = turns
        self._file, self._container = _open_container(name)
        try:
            self._stream = _choose_stream(name, self._container.streams.video)
            self._stream.codec_context.options = _DECODER_OPTIONS
            is_small = self._stream.width * self._stream.height <= MAX_SINGLE_THREAD_PIXELS
            self._stream.thread_type = "NONE" if is_paced and is_small else "AUTO"
        except BaseException:
            self.close()
            raise
        self.fps = _sane_fps(self._stream.average_rate or self._stream.guessed_rate)
        self.frame_count = self._count()
        self._deinterlacer = Deinterlacer(self._stream)
        self._choice = TimestampChoice(has_presentation_times=self._container.format.name != "avi")
        self._reformatter = av.video.reformatter.VideoReformatter()  # one for all frames: its tables are made once
        self._next_time = 0.0

    def close(self) -> None:
        """Close container and file."""
        self._container.close()
        if self._file is not None:
            self._file.close()

    def _count(self) -> int | None:
        if self._stream.frames > 0:
            return int(self._stream.frames)
        if self._stream.duration and self._stream.time_base:
            return max(1, round(float(self._stream.duration * self._stream.time_base) * self.fps))
        return None

    def frames(self) -> Generator[Frame]:
        """Yield the frames as upright BGR images with square pixels; timestamps are the file's own, in seconds.

        An image like the one before, which could be converted, is converted when somebody asks for it.
        """
        convertible: tuple[str, int, int] | None = None
        for decoded in _decode_all(self._container, self._stream):
            if decoded is not None and decoded.is_corrupt:
                continue
            if decoded is not None:
                decoded.pts = self._choice.choose(decoded.pts, decoded.dts)
            for frame in self._deinterlacer.push(decoded):
                stated = frame.time
                self._next_time = (self._next_time if stated is None else float(stated)) + 1 / self.fps
                kind = (frame.format.name, frame.width, frame.height)
                convert = partial(self._to_bgr, frame, float(self._stream.sample_aspect_ratio or 1))
                try:
                    pixels = convert if kind == convertible else convert()
                except CameraError:
                    continue
                convertible = kind
                yield Frame(pixels, self._next_time - 1 / self.fps)

    def _to_bgr(self, frame: Any, aspect: float) -> NDArray[np.uint8]:
        """Return the upright image with square pixels. Raises CameraError if its pixel format cannot be converted.

        aspect : width over height of a pixel. Not read here: the file may be closed, after which its stream is no more.
        """
        width, height = square_pixel_size(frame.width, frame.height, aspect, max_pixels=MAX_PIXELS)
        try:
            # Threads of its own would cost more than they save at the sizes of webcams.
            image = self._reformatter.reformat(frame, width=width, height=height, format="bgr24", threads=1)
        except _CLIP_ERRORS as error:
            reason = f"a picture cannot be converted ({_reason(error)})"
            raise CameraError(f"{self._name}: {reason}; convert the clip to MP4.") from error
        pixels = turn_by_matrix(np.asarray(image.to_ndarray(), np.uint8), _display_matrix(frame))
        return np.ascontiguousarray(np.rot90(pixels, self._turns)) if self._turns else pixels


def open_clip(path: Path | str, /, *, loop: bool = False, turns: int = 0, is_paced: bool = False) -> Clip:
    """Open a video file, or pictures named by a pattern as in `frames/%04d.png`. Raises CameraError.

    loop : begin again at the end, timestamps going on
    turns : quarter turns, counterclockwise, of the frames beside the rotation that the file states
    is_paced : frames are read at the clip's own speed, not as fast as possible
    """
    return Clip(str(path), loop=loop, turns=turns, is_paced=is_paced)


def read_sound(path: Path | str, /, *, rate: int = SOUND_RATE) -> Generator[tuple[float, NDArray[np.int16]]]:
    """Yield a clip's sound track in blocks: time of the first sample in seconds of the file, (n,) mono int16 samples.

    rate : samples a second
    Yields nothing if the clip has no sound. Raises CameraError if it cannot be opened.
    """
    name = str(path)
    file, container = _open_container(name)
    with contextlib.ExitStack() as stack:
        if file is not None:
            stack.enter_context(file)
        stack.enter_context(container)
        stream = next(iter(container.streams.audio), None)
        if stream is None or stream.codec_context is None:
            return
        resampler = _Resampler(rate)
        at: float | None = None
        expected = 0.0  # time of the next decoded sample if there is no gap; the resampler holds back a few samples
        for decoded in _decode_all(container, stream):
            if decoded is not None:
                stated = expected if decoded.time is None else float(decoded.time)
                at = stated if at is None or abs(stated - expected) > MAX_SOUND_GAP_S else at
                expected = stated + decoded.samples / (decoded.sample_rate or rate)
            at = at or 0.0
            for samples in resampler.resample(decoded):
                yield at, samples
                at += len(samples) / rate


class _Resampler:
    """Converts decoded sound to mono at one rate, though its rate, channels or format may change in the middle."""

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._format: tuple[str, str, int] | None = None
        self._resampler: av.AudioResampler | None = None

    def resample(self, decoded: Any) -> Iterator[NDArray[np.int16]]:
        """Yield what is ready, (n,) samples; None flushes."""
        format_ = decoded and (decoded.format.name, decoded.layout.name, decoded.sample_rate)
        try:
            blocks = self._resampler.resample(None) if self._resampler and format_ != self._format else []
            if decoded and format_ != self._format:
                self._resampler = av.AudioResampler(format="s16", layout="mono", rate=self._rate)
            self._format = format_
            if decoded and self._resampler:
                blocks += self._resampler.resample(decoded)
        except _CLIP_ERRORS:
            self._format = self._resampler = None
            return
        yield from (np.asarray(block.to_ndarray(), np.int16).reshape(-1) for block in blocks)


def _decode_all(container: Any, stream: Any) -> Iterator[Any]:
    """Yield decoded frames of a stream, then None to flush what follows; a damaged packet costs its own frames."""
    bad = 0
    packets = container.demux(stream)
    while bad < MAX_BAD_PACKETS:
        try:
            packet = next(packets, None)
            if packet is None:
                break
            yield from packet.decode()
            bad = 0
        except _CLIP_ERRORS:
            bad += 1
    yield None


def _open_container(name: str) -> tuple[IO[bytes] | None, Any]:
    """Open a file, or pictures by a pattern. Raises CameraError with what to do."""
    av.logging.set_level(None)  # what matters reaches the user as an error
    if "%" in name and not Path(name).exists():
        return None, _open_pattern(name)
    try:
        _check_is_file(name)
        file = open(name, "rb")
    except FileNotFoundError:
        raise CameraError(_missing(name)) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise CameraError(f"{name} cannot be opened ({reason}): give a video file that may be read.") from error
    try:
        if claims_more_than_it_holds(file):
            raise ValueError("its index names more frames than it has bytes")
        return file, av.open(file, "r")
    except _CLIP_ERRORS as error:
        file.close()
        raise CameraError(
            f"{name} is not a video that can be read ({_reason(error)}): give one such as MP4, MKV, AVI or MPG."
        ) from error


def _check_is_file(name: str) -> None:
    """Raise CameraError for what could be opened but would never end, or block. Raises OSError, ValueError."""
    mode = os.stat(name).st_mode
    if stat.S_ISCHR(mode):
        raise CameraError(f"{name} is a device, not a file: if it is a camera, give it with --camera.")
    if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode):
        raise CameraError(f"{name} is a pipe, not a file: write the clip to a file first, then give its path.")


def _open_pattern(name: str) -> Any:
    """Open pictures such as frames/%04d.png."""
    wildcard = "*".join(glob.escape(part) for part in _PATTERN.split(name))
    if not _PATTERN.search(name) or not glob.glob(wildcard):
        raise CameraError(_missing(name))
    try:
        return av.open("file:" + name, "r", format="image2", options={"framerate": _PATTERN_FPS})
    except (UnicodeEncodeError, *_CLIP_ERRORS) as error:
        raise CameraError(
            f"the pictures {name} cannot be read ({_reason(error)}): number them from 0 to 4 on."
        ) from error


def _missing(name: str) -> str:
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:/", name):  # a path has lost the second slash of an address
        return f"{name} is an address, not a file: download the clip first, then give its path."
    return f"there is no file {name}: check the path, or name pictures by a pattern such as frames/%04d.png."


def _reason(error: BaseException) -> str:
    return str(getattr(error, "strerror", None) or error) or type(error).__name__


def _is_cover(stream: Any) -> bool:
    """Return whether a video stream is a still picture of a sound file."""
    return bool(stream.disposition & av.stream.Disposition.attached_pic)


def _choose_stream(name: str, streams: Any) -> Any:
    """Return the video stream to show: the one marked as default, else the largest. Raises CameraError."""
    moving = [stream for stream in streams if not _is_cover(stream)]
    if not moving:
        raise CameraError(f"{name} has no picture: give a video.")
    decodable = [stream for stream in moving if stream.codec_context is not None]
    if not decodable:
        raise CameraError(f"{name} has a picture in a coding that this program has no decoder for: convert it.")
    chosen = max(decodable, key=lambda s: (bool(s.disposition & av.stream.Disposition.default), s.width * s.height))
    if chosen.width * chosen.height > MAX_PIXELS:
        raise CameraError(
            f"{name} has pictures of {chosen.width} x {chosen.height} pixels, more than can be read: make them smaller."
        )
    return chosen


def _display_matrix(frame: Any) -> NDArray[np.int32] | None:
    """Return the nine numbers of a frame's display matrix, or None if it has none."""
    try:
        data = frame.side_data.get("DISPLAYMATRIX")
    except ValueError:  # PyAV does not know every kind of side data, such as that of EXIF
        turns = round(frame.rotation / 90) % 4
        a, b = ((1, 0), (0, -1), (-1, 0), (0, 1))[turns]
        return np.array((a, b, 0, -b, a, 0, 0, 0, 1), np.int32)
    return None if data is None else np.frombuffer(data, np.int32)


def _fitted(frame: Frame, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return a frame's image in this size, width and height in pixels."""
    return frame.pixels if frame.pixels.shape[1::-1] == size else fit_into(frame.pixels, size)


def _sane_fps(rate: Any) -> float:
    fps = float(rate) if rate else 0.0
    return fps if math.isfinite(fps) and 0 < fps <= MAX_FPS else DEFAULT_FPS
