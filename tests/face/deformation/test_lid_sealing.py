from dataclasses import replace

import numpy as np
import pytest

from conf.face.animation.action_units import combine_action_units
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import default_points
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lid_sealing import seal_lids
from conf.face.fitting.custom_face import prepare_face
from conf.face.loading import build_face
from conf.face.mesh.raycast import cast_front_rays
from tests.support.modified_heads import EYEBALLS, head_without


@pytest.fixture(scope="module")
def eyeless() -> FaceModel:
    """Return the default head with eyeballs that were put in: its lids do not fit them."""
    face = prepare_face(head_without(*EYEBALLS), default_points())
    return build_face(face.mesh, face.points, rig=face.rig)


def visible_eye(face: FaceModel, vertices: np.ndarray) -> float:
    """Return the area, cm2, of the left eyeball that is visible from the front."""
    x, y = np.meshgrid(np.arange(1.5, 5.2, 0.04), np.arange(1.8, 3.6, 0.04))
    hits = cast_front_rays(np.stack([x.ravel(), y.ravel()], 1), vertices.astype(np.float64), face.mesh.triangles)
    return float(np.isin(hits.triangles, face.mesh.groups["eye_l"]).sum() * 0.04**2)


@pytest.mark.slow
def test_no_slit_is_open_in_a_blink(eyeless: FaceModel) -> None:
    blink = combine_action_units({45: 1.0})
    assert visible_eye(eyeless, eyeless.neutral) > 1.0
    assert visible_eye(eyeless, eyeless.deform(blink)) < 0.01
    assert visible_eye(eyeless, eyeless.deform(3 * blink)) < 0.01


@pytest.mark.slow
def test_a_slit_is_closed_by_the_skin_above_it(eyeless: FaceModel) -> None:
    blink, column = combine_action_units({45: 1.0}), CONTROL_POINT_INDEX["eyelid_upper_l"]
    operator = eyeless.operator.copy()
    near_corner = (np.abs(eyeless.neutral - eyeless.control_points[column])[:, 0] > 0.7) & (eyeless.neutral[:, 0] > 0)
    operator[near_corner, column] *= np.float32(0.7)
    leaking = replace(eyeless, operator=operator)
    sealed = seal_lids(leaking)
    before, after = (visible_eye(face, face.deform(blink)) for face in (leaking, sealed))
    assert after < 0.01 < 0.02 < before
    changed = np.flatnonzero((sealed.operator != operator).any(axis=1))
    assert (sealed.operator != operator)[:, np.arange(50) != column].sum() == 0
    assert np.linalg.norm(eyeless.neutral[changed] - eyeless.control_points[column], axis=1).max() < 3.0
    assert not np.isin(changed, sealed.rig.rigid if sealed.rig else []).any()


def test_a_face_without_eyes_stays_as_it_is(eyeless: FaceModel) -> None:
    blind = replace(eyeless, rig=None)
    assert seal_lids(blind) is blind
