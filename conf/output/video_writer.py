"""Write clips without delaying a window: encoding runs in a thread of its own."""

import contextlib
import shutil
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import interrupted_note, partial_path, report_write_errors, write_target
from conf.errors import RecordingError
from conf.output.clip_encoder import ENCODER_ERRORS, ClipEncoder, clip_format, move_index_to_front

MIN_FREE_BYTES = 16 << 20  # a clip ends before the disk is full, so that it can still be completed
DISK_CHECK_INTERVAL = 30  # frames
MAX_WAITING = 8  # frames that wait for the encoder: 22 MB at 1280x720
MIN_FRAME_STEP = 0.75  # of 1/fps: images at shorter intervals are left out; less than 1 as a loop's intervals vary
AUDIO_RATES = (16_000, 48_000)  # samples a second
AUDIO_TOLERANCE_S = 0.04  # a larger difference between a block's time and the sound so far is a gap or an overlap


class VideoWriter:
    """Writes an MP4 (H.264, frames at their own times) or AVI (Motion JPEG) file. All frames have the first one's size.

    The file gets its name when it is complete. A clip that ends by an error or an interrupt keeps its partial name, and
    an older file of that name stays; a note of the exception says so.
    frames : number of frames written
    """

    def __init__(self, path: Path, *, fps: float, audio_rate: int | None = None) -> None:
        """Create the file.

        fps : frames a second, at most; audio_rate : of a mono sound track, samples a second, None for no sound
        Raises RecordingError if the file cannot be created, ValueError if an argument is out of range.
        """
        if not fps > 0:
            raise ValueError(f"fps must be positive, got {fps}")
        if audio_rate not in (None, *AUDIO_RATES):
            raise ValueError(f"audio_rate must be one of {AUDIO_RATES}, got {audio_rate}")
        self._format = clip_format(path)
        with report_write_errors(path, RecordingError):
            self.path = write_target(path.absolute())
        self.frames = 0
        self._fps = fps
        self._audio_rate = audio_rate
        self._partial = partial_path(self.path)
        self._size = (0, 0)
        self._began: float | None = None
        self._last_time = 0.0  # of the newest frame, s from the start
        self._audio_end = 0  # samples
        self._encoder: ClipEncoder | None = None
        self._thread: ThreadPoolExecutor | None = None
        self._waiting: deque[Future[None]] = deque()  # frames and sound
        self._waiting_frames: deque[Future[None]] = deque()
        with report_write_errors(self.path, RecordingError):
            self._partial.touch()

    def write(self, pixels: NDArray[np.uint8]) -> None:
        """Add a frame, (H, W, 3) uint8 BGR, 1/fps after the last; it must not be changed afterwards.

        One of another size, after the window was resized, is scaled. Waits for the encoder.
        Raises RecordingError when the disk is full.
        """
        self._write(pixels, [self.frames / self._fps])

    def write_at(self, read: Callable[[], NDArray[np.uint8]], now: float) -> None:
        """Add the image shown at `now`, seconds on a clock of the caller, unless one was added just before.

        Does not wait: an image that comes while the encoder is late is left out. In an AVI the images are repeated as
        its frame rate requires.
        read : returns the image; called only if it is needed
        """
        self._began = now if self._began is None else self._began
        time = now - self._began
        if self._count_waiting() >= MAX_WAITING:
            return
        if not self._format.true_times:
            due = [i / self._fps for i in range(self.frames, int(time * self._fps) + 1)]
        else:
            due = [time] if not self.frames or time - self._last_time >= MIN_FRAME_STEP / self._fps else []
        if due:
            self._write(read(), due)

    def write_audio(self, samples: NDArray[np.int16], now: float) -> None:
        """Add (n,) mono samples, the first heard at `now` on the clock of `write_at`.

        Gaps are filled with silence, overlaps are cut, and sound from before the first image is left out.
        """
        if samples.ndim != 1 or samples.dtype != np.int16:
            raise ValueError(f"samples must be (n,) int16, got {samples.shape} {samples.dtype}")
        if self._audio_rate is None:
            raise ValueError("audio_rate must be given for a clip with sound")
        if self._encoder is None or self._began is None:
            return
        position = round((now - self._began) * self._audio_rate)
        gap = position - self._audio_end
        if abs(gap) <= AUDIO_TOLERANCE_S * self._audio_rate and (self._audio_end or gap >= 0):
            gap = 0
        if gap > 0:
            samples = np.concatenate([np.zeros(gap, np.int16), samples])
        elif gap < 0:
            samples = samples[-gap:]
        if len(samples):
            encoder, start = self._encoder, self._audio_end
            self._audio_end += len(samples)
            self._submit(lambda: encoder.encode_audio(samples, start))

    def close(self) -> Path | None:
        """Complete the file and give it its name. Returns the full path, or None if there are no frames.

        Raises RecordingError.
        """
        if not self._finish():
            return None
        with report_write_errors(self.path, RecordingError):
            self._move_index()
            self._partial.replace(self.path)
        return self.path

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if error is None:
            self.close()
            return
        with contextlib.suppress(RecordingError):  # the first error is the one to report
            self._finish()
        if self._partial.exists():
            error.add_note(interrupted_note(self.path))

    def _write(self, pixels: NDArray[np.uint8], times: list[float]) -> None:
        if self.frames % DISK_CHECK_INTERVAL == 0 and shutil.disk_usage(self.path.parent).free < MIN_FREE_BYTES:
            raise RecordingError(f"{self.path}: the disk is full; free some space or choose another folder")
        if self._encoder is None:
            self._began = 0.0 if self._began is None else self._began
            self._size = (pixels.shape[1], pixels.shape[0])
            with report_write_errors(self.path, RecordingError):
                self._encoder = ClipEncoder(
                    self._partial, self._format, self._size, fps=self._fps, audio_rate=self._audio_rate
                )
        if (pixels.shape[1], pixels.shape[0]) != self._size:
            pixels = np.asarray(cv2.resize(pixels, self._size, interpolation=cv2.INTER_AREA), np.uint8)
        encoder = self._encoder

        def encode() -> None:
            for time in times:
                encoder.encode_frame(pixels, time)

        while self._count_waiting() >= MAX_WAITING:
            self._result(self._waiting.popleft())
        self.frames += len(times)
        self._last_time = times[-1]
        self._waiting_frames.append(self._submit(encode))

    def _submit(self, task: Callable[[], None]) -> Future[None]:
        """Run a task in the encoder's thread after those that wait."""
        if self._thread is None:
            self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="clip encoder")
        future = self._thread.submit(task)
        self._waiting.append(future)
        return future

    def _count_waiting(self) -> int:
        """Return how many frames wait for the encoder. Raises the error of a finished task."""
        while self._waiting and self._waiting[0].done():
            self._result(self._waiting.popleft())
        while self._waiting_frames and self._waiting_frames[0].done():
            self._waiting_frames.popleft()
        return len(self._waiting_frames)

    def _result(self, task: Future[None]) -> None:
        try:
            task.result()
        except ENCODER_ERRORS as error:
            reason = getattr(error, "strerror", None) or error
            raise RecordingError(f"{self.path} cannot be written ({reason}); choose another file or folder") from error

    def _finish(self) -> bool:
        """Complete the partial file, or remove it if it has no frames. Returns whether there is one."""
        if self._encoder is None:
            self._partial.unlink(missing_ok=True)
            return False
        encoder, self._encoder = self._encoder, None
        assert self._thread is not None
        closing = self._thread.submit(encoder.close)
        self._thread.shutdown()
        waiting, self._waiting = [*self._waiting, closing], deque()
        for task in waiting:
            self._result(task)
        return True

    def _move_index(self) -> None:
        """Move the clip's index to the front if there is room for a copy; the clip is complete without that."""
        copy = partial_path(self._partial)
        try:
            if move_index_to_front(self._partial, self._format, copy):
                copy.replace(self._partial)
        except ENCODER_ERRORS:
            copy.unlink(missing_ok=True)
