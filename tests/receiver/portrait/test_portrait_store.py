from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.portrait import NeutralPoseUpdate, encode_object
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.receiver.portrait.portrait_store import PortraitStore
from tests.support.drawn_person import patch, photograph
from tests.support.synthetic_portrait import POSE


def test_a_photograph_and_its_patches_are_kept() -> None:
    album = PortraitStore()
    assert album.receive(encode_object(photograph()))
    assert album.receive(encode_object(patch(slot=2)))
    assert album.photo is not None and album.photo.pixels.shape == (240, 320, 3)
    assert list(album.patches) == [(0, 2)]


def test_what_comes_before_its_photograph_waits_for_it() -> None:
    album = PortraitStore()
    neutral = photograph().neutral + 0.2
    album.receive(encode_object(patch(photograph=4)))
    album.receive(encode_object(NeutralPoseUpdate(4, neutral, photograph().fapu)))
    assert not album.patches
    album.receive(encode_object(photograph(4)))
    assert album.patches and album.photo is not None
    points = album.photo.warp.control_points(np.zeros((CONTROL_POINT_COUNT, 3)))
    np.testing.assert_allclose(points[0], neutral[0], atol=0.011)


def test_a_new_photograph_does_away_with_the_patches_of_the_old() -> None:
    album = PortraitStore()
    for thing in (photograph(1), patch(photograph=1), photograph(2)):
        album.receive(encode_object(thing))
    assert not album.patches


def test_patches_are_bounded() -> None:
    album = PortraitStore()
    album.receive(encode_object(photograph()))
    for number in range(100):
        album.receive(encode_object(patch(number % 2, number % MAX_SLOTS, photograph=number % 4)))
    assert len(album.patches) <= len(FEATURES) * MAX_SLOTS


@pytest.mark.parametrize(
    "thing",
    [
        replace(photograph(), points=np.zeros_like(photograph().points), neutral=photograph().neutral * 0),
    ],
    ids=["flat"],
)
def test_what_is_no_face_is_refused_and_the_call_goes_on(thing: object) -> None:
    album = PortraitStore()
    album.receive(encode_object(photograph()))
    before = album.photo
    assert not album.receive(encode_object(thing))  # type: ignore[arg-type]
    assert album.rejected == 1 and album.photo is before


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(0, 40))
def test_any_face_is_moved_or_refused(seed: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    good = photograph()
    pose = np.concatenate([rng.uniform(-3, 3, 3), rng.uniform(-3, 3, 2), [rng.uniform(-6, 0.5)]])
    points = np.clip(good.points + rng.normal(0, spread, good.points.shape), -60, 60)
    wild = replace(good, points=points, neutral=points[:CONTROL_POINT_COUNT], pose=pose)
    album = PortraitStore()
    if album.receive(encode_object(wild)):
        assert album.photo is not None
        places = album.photo.warp.deform(rng.normal(0, 300, (CONTROL_POINT_COUNT, 3)), POSE)
        assert np.isfinite(places).all()
    else:
        assert album.rejected == 1


@given(st.binary(max_size=300))
def test_any_bytes_do_no_harm(data: bytes) -> None:
    album = PortraitStore()
    album.receive(data)
    assert album.photo is None
