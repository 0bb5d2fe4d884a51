import csv
from pathlib import Path

import numpy as np
import pytest

from conf.commands.extract import extract
from conf.errors import CameraError, RecordingError
from conf.face.formats.dpc import read_dpc
from conf.face.retargeting.arkit_csv import SHAPES
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
def test_the_trackers_blendshapes_of_a_clip_are_written(short_clip: Path, tmp_path: Path) -> None:
    extract(short_clip, tmp_path / "weights.csv")
    rows = list(csv.DictReader((tmp_path / "weights.csv").read_text().splitlines()))
    assert len(rows) == SHORT
    weights = np.array([[float(row[name[0].upper() + name[1:]]) for name in SHAPES] for row in rows])
    assert np.ptp(weights, axis=0).max() > 0.05  # the face moves
    assert (weights >= 0).all() and (weights <= 1).all()
    assert (weights[:, SHAPES.index("tongueOut")] == 0).all()


@pytest.mark.slow
def test_a_clip_without_a_face_is_an_error(empty_clip: Path, tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="shows no face: choose a clip in which one face is clearly visible"):
        extract(empty_clip, tmp_path / "motion.dpc")
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_an_error(short_clip: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"motion\.dpc cannot be written \(No such file or directory\); choose"):
        extract(short_clip, tmp_path / "nowhere" / "motion.dpc")
