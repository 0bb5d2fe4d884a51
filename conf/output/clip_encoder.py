"""Encode images and sound into a clip with PyAV (FFmpeg).

Strategy. An MP4 is written in fragments, so that a file whose program was killed can be played up to its last seconds.
When it is closed, FFmpeg turns it into an ordinary MP4, and `move_index_to_front` copies it so that it can be played
while it is downloaded. The file is opened by Python, never by name: FFmpeg would interpret a colon in it.
"""

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import av.error
import av.logging
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from numpy.typing import NDArray

from conf.errors import RecordingError

CLOCK = Fraction(
    1, 60_000
)  # s, of clips with true times: exact at 24, 25, 29.97 and 30 frames a second; MPEG-4's limit is 65,535
KEYFRAME_INTERVAL_S = 2.0  # at most this much is lost when the program is killed
QUANTISER = 3  # of codecs without a quality setting; 2 is the best of MPEG-4 and Motion JPEG, 31 the worst
LAMBDA_PER_QUANTISER = 118  # FFmpeg's FF_QP2LAMBDA
ENCODER_ERRORS = (av.error.FFmpegError, OSError, ValueError)  # what PyAV raises
_FIXED_QUANTISER = {"flags": "+qscale", "global_quality": str(QUANTISER * LAMBDA_PER_QUANTISER)}


@dataclass(frozen=True)
class ClipFormat:
    """A container with its codecs.

    video : names of encoders with their options, in the order of preference
    even_size : whether width and height must be even
    true_times : whether a frame can have any time; otherwise there are `fps` frames each second
    """

    container: str
    video: dict[str, dict[str, str]]
    pixel_format: str
    audio: str
    even_size: bool
    true_times: bool
    options: dict[str, str] = field(default_factory=dict)


CLIP_FORMATS = {
    ".mp4": ClipFormat(
        "mp4",
        # No B-frames: their reordering would start the clip after 0. CRF 20 is visually lossless for drawn faces.
        {"libx264": {"preset": "veryfast", "crf": "20", "bf": "0"}, "mpeg4": _FIXED_QUANTISER},
        "yuv420p",
        "aac",
        even_size=True,
        true_times=True,
        options={"movflags": "+hybrid_fragmented+delay_moov"},
    ),
    ".avi": ClipFormat("avi", {"mjpeg": _FIXED_QUANTISER}, "yuvj420p", "pcm_s16le", even_size=False, true_times=False),
}


def clip_format(path: Path, /) -> ClipFormat:
    """Return the format that a file name's suffix stands for. Raises RecordingError for others."""
    found = CLIP_FORMATS.get(path.suffix.lower())
    if found is None:
        raise RecordingError(f"{path}: the name of a clip must end in {' or '.join(CLIP_FORMATS)}")
    return found


class ClipEncoder:
    """Encodes one clip; its methods may take long and must be called by one thread at a time."""

    def __init__(
        self, path: Path, format: ClipFormat, size: tuple[int, int], *, fps: float, audio_rate: int | None = None
    ) -> None:
        """Create a file.

        size : width and height of the frames, pixels; fps : nominal, frames a second
        audio_rate : samples a second of the sound track, None for none
        """
        av.logging.set_level(None)  # what matters reaches the user as an error
        self._format = format
        self._size = size
        self._padding = (size[1] % 2, size[0] % 2) if format.even_size else (0, 0)
        self._rate = Fraction(fps).limit_denominator(1001)
        self._file = path.open("w+b", buffering=0)
        try:
            self._container: Any = av.open(self._file, "w", format=format.container, options=format.options)
            self._video = self._add_video()
            self._audio = None if audio_rate is None else self._add_audio(audio_rate)
        except BaseException:
            self._file.close()
            raise

    def encode_frame(self, pixels: NDArray[np.uint8], time: float) -> None:
        """Add a frame, (H, W, 3) uint8 BGR, shown from `time`, seconds of the clip."""
        bottom, right = self._padding
        if bottom or right:
            pixels = np.pad(pixels, ((0, bottom), (0, right), (0, 0)), mode="edge")
        picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="bgr24")
        is_full_range = self._format.pixel_format.startswith("yuvj")
        frame = picture.reformat(
            format=self._format.pixel_format,
            dst_colorspace=Colorspace.ITU601,
            dst_color_range=ColorRange.JPEG if is_full_range else ColorRange.MPEG,
        )
        frame.time_base = self._video.codec_context.time_base
        frame.pts = round(time / frame.time_base)
        self._container.mux(self._video.encode(frame))

    def encode_audio(self, samples: NDArray[np.int16], position: int) -> None:
        """Add (n,) mono samples, the first at `position`, in samples from the start of the clip."""
        if self._audio is None:
            raise ValueError("audio_rate must be given for a clip with sound")
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = self._audio.rate
        frame.time_base, frame.pts = Fraction(1, self._audio.rate), position
        self._container.mux(self._audio.encode(frame))

    def close(self) -> None:
        """Complete the file."""
        try:
            for stream in filter(None, (self._video, self._audio)):
                self._container.mux(stream.encode(None))
        finally:
            try:
                self._container.close()
            finally:
                self._file.close()

    def _add_video(self) -> Any:
        name, options = next((n, o) for n, o in self._format.video.items() if n in av.codecs_available)
        interval = max(1, round(KEYFRAME_INTERVAL_S * self._rate))
        stream = self._container.add_stream(name, options={**options, "g": str(interval)})
        bottom, right = self._padding
        stream.width, stream.height = self._size[0] + right, self._size[1] + bottom
        stream.pix_fmt = self._format.pixel_format
        context = stream.codec_context
        context.framerate = self._rate
        context.time_base = CLOCK if self._format.true_times else 1 / self._rate
        context.colorspace = Colorspace.ITU601  # what readers assume that ignore it
        return stream

    def _add_audio(self, rate: int) -> Any:
        return self._container.add_stream(self._format.audio, rate=rate, layout="mono")


def move_index_to_front(path: Path, format: ClipFormat, copy: Path, /) -> bool:
    """Write a copy of a clip with its index before its data. Returns False if the format has no such index."""
    if "movflags" not in format.options:
        return False
    with path.open("rb") as source, copy.open("w+b") as target:

        def open_again(*_: object) -> Any:  # FFmpeg reads what it has written, to shift it
            return copy.open("rb")

        options = {"movflags": "+faststart"}
        with (
            av.open(source, "r") as old,
            av.open(target, "w", format=format.container, options=options, io_open=open_again) as new,
        ):
            streams = {stream.index: new.add_stream_from_template(stream) for stream in old.streams}
            for packet in old.demux():
                if packet.dts is not None:  # None flushes a decoder
                    packet.stream = streams[packet.stream.index]
                    new.mux(packet)
    return True
