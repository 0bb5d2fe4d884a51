from pathlib import Path

import numpy as np
import pytest

from conf.sender.tracking.blendshape_network import _INPUTS, BLENDSHAPE_NAMES, INDEX, BlendshapeNetwork


def test_there_are_52_shapes_and_146_inputs() -> None:
    assert len(BLENDSHAPE_NAMES) == len(set(BLENDSHAPE_NAMES)) == 52
    assert (INDEX["eyeBlinkLeft"], INDEX["jawOpen"], INDEX["noseSneerRight"]) == (9, 25, 51)
    assert len(_INPUTS) == len(set(_INPUTS)) == 146
    assert _INPUTS.max() == 477


@pytest.mark.slow
def test_blinks_and_the_jaw_follow_the_landmarks_at_any_size(models: Path, shared: Path) -> None:
    track = np.load(shared / "motion" / "grid_bbaf2n.npz")
    landmarks = (track["landmarks"] / track["scale"]).astype(np.float32)
    network = BlendshapeNetwork(models)
    shapes = np.array([network.predict(frame) for frame in landmarks])
    lid_gap = landmarks[:, 374, 1] - landmarks[:, 386, 1]
    assert np.corrcoef(lid_gap, shapes[:, INDEX["eyeBlinkLeft"]])[0, 1] < -0.9
    mouth_gap = landmarks[:, 14, 1] - landmarks[:, 13, 1]
    assert np.corrcoef(mouth_gap, shapes[:, INDEX["jawOpen"]])[0, 1] > 0.9
    assert np.allclose(network.predict(landmarks[0] * 3), shapes[0], atol=1e-3)
