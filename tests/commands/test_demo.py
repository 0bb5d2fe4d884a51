from pathlib import Path

import numpy as np
import pytest

from conf.commands.demo import demo, there_and_back
from conf.errors import ConfError
from conf.sender.capture.clip import open_clip
from tests.support.generated_clips import SIZE, square_left, write_clip

FRAMES = 8
FPS = 25


@pytest.mark.slow
def test_the_message_of_a_failed_sender_is_reported(
    gl: None, monkeypatch: pytest.MonkeyPatch, short_clip: Path, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setattr("conf.sender.tracking.model_files.fetch_demo_clip", lambda: short_clip)
    with pytest.raises(ConfError, match=r"no frame was received: conf: face_landmarker\.task is not in"):
        demo(seconds=30.0, headless=True)


@pytest.mark.slow
def test_the_clip_is_played_forwards_and_backwards(tmp_path: Path) -> None:
    times = [frame / FPS for frame in range(FRAMES)]
    write_clip(tmp_path / "there.mp4", times)
    path = there_and_back(tmp_path / "there.mp4", tmp_path / "back.mp4")
    with open_clip(path) as clip:
        assert clip.size == SIZE and clip.fps == pytest.approx(FPS)
        lefts = [square_left(frame.pixels) for frame in iter(clip.read, None)]
    forward = lefts[:FRAMES]
    assert np.all(np.diff(forward) > 0) and lefts[FRAMES:] == pytest.approx(forward[-2:0:-1], abs=1)
