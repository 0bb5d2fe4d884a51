import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.portrait import contours
from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH, PatchRegion
from tests.support.synthetic_portrait import face_points


@pytest.mark.parametrize("region", FEATURES, ids=lambda f: f.name)
def test_a_patch_is_opaque_at_its_centre_and_transparent_far_away(region: PatchRegion) -> None:
    positions_cm = face_points()[:, :2]
    weights = region.weights(positions_cm)
    np.testing.assert_allclose(weights[contours.landmark_rows(region.centre_landmarks)], 1)
    assert weights[CONTROL_POINT_INDEX["chin_bottom"]] == 0
    assert region.near(positions_cm, 0.1)[contours.landmark_rows(region.centre_landmarks)].all()


def test_descriptors_of_an_open_mouth_and_a_blink_differ() -> None:
    still = np.zeros((CONTROL_POINT_COUNT, 3))
    opened, blink = still.copy(), still.copy()
    opened[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] = -800
    blink[[CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]], 1] = -1024
    assert np.linalg.norm(MOUTH.quantised_descriptor(opened).astype(float)) > 20
    assert np.linalg.norm(EYES.quantised_descriptor(blink).astype(float)) > 20
    assert not EYES.quantised_descriptor(opened).any() and not MOUTH.quantised_descriptor(blink).any()


def test_a_quantised_descriptor_is_clipped_to_int8() -> None:
    wild = np.full((CONTROL_POINT_COUNT, 3), 1e6)
    assert MOUTH.quantised_descriptor(wild).dtype == np.int8
