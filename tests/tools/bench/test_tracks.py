from pathlib import Path

import numpy as np
import pytest

from tools.bench.tracks import TrackReader


@pytest.mark.slow
def test_a_track_is_resampled_and_its_error_is_measured_in_the_image(shared: Path) -> None:
    reader = TrackReader()
    track = reader.read(shared / "motion" / "man_smiles.npz", fps=15)
    assert len(track.frames) == 36  # 72 frames at 30 a second
    assert np.diff([frame.timestamp for frame in track.frames]) == pytest.approx(1 / 15)
    frame = track.frames[10]
    assert track.image_errors(10, frame.displacements, frame.pose).max() == 0
    moved = frame.pose + 0.01 * track.eye_distance[10] * np.eye(6)[3]
    assert track.image_errors(10, frame.displacements, moved) == pytest.approx(np.ones(50), abs=1e-6)
