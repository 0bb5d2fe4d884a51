"""Track a clip as fast as the machine can: for `extract` and `measure`."""

from collections.abc import Callable, Iterator
from pathlib import Path

from conf.sender.capture.clip import open_clip
from conf.sender.capture.frame import Frame
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

Progress = Callable[[int], None]  # called with the number of frames done


def track_clip(clip: Path, on_progress: Progress | None = None) -> Iterator[tuple[Frame, TrackedFace | None]]:
    """Yield each frame of a clip with the face in it, or None. Raises CameraError, ModelError."""
    tracker = FaceTracker(fetch_models())
    with open_clip(clip) as source:
        for count, frame in enumerate(iter(source.read, None)):
            yield frame, tracker.track(frame.pixels)
            if on_progress:
                on_progress(count + 1)
