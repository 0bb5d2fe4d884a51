from pathlib import Path

import numpy as np
import pytest

from conf.commands.extract import extract
from conf.errors import CameraError, RecordingError
from conf.face.formats.dpc import read_dpc
from tests.support.short_clips import SHORT


@pytest.mark.slow
def test_the_motion_of_a_clip_is_written(short_clip: Path, tmp_path: Path) -> None:
    result = extract(short_clip, tmp_path / "motion.dpc")
    motion = read_dpc(tmp_path / "motion.dpc")
    assert (result.frames, result.frames_tracked) == (SHORT, SHORT)
    assert motion.displacements.shape == (SHORT, 50, 3) and motion.fps == pytest.approx(30)
    assert motion.poses is not None and np.abs(np.diff(motion.poses, axis=0)).max() < 0.2
    assert np.ptp(motion.displacements[:, :, 1]) > 20  # the mouth moves


@pytest.mark.slow
def test_a_clip_without_a_face_is_an_error(empty_clip: Path, tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="shows no face: choose a clip in which one face is clearly visible"):
        extract(empty_clip, tmp_path / "motion.dpc")
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_an_error(short_clip: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"motion\.dpc cannot be written \(No such file or directory\); choose"):
        extract(short_clip, tmp_path / "nowhere" / "motion.dpc")
