from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.portrait.background import Background
from conf.protocol.portrait.objects import encode_object
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.portrait.photo import NeutralPoseUpdate
from conf.receiver.portrait.portrait_store import PortraitStore, decode_image
from tests.support.drawn_person import draw_person, encode_vp8, make_patch, make_photo, make_view
from tests.support.synthetic_portrait import POSE


@pytest.mark.slow
def test_a_photo_and_its_patches_are_kept() -> None:
    store = PortraitStore()
    assert store.receive(encode_object(make_photo()))
    assert store.receive(encode_object(make_patch(slot=2)))
    assert store.photo is not None and store.photo.pixels.shape == (240, 320, 3)
    assert list(store.patches) == [(0, 2)]


@pytest.mark.slow
def test_updates_that_arrive_before_their_photo_are_applied_to_it() -> None:
    store = PortraitStore()
    neutral = make_photo().neutral + 0.2
    store.receive(encode_object(make_patch(photo_number=4)))
    store.receive(encode_object(NeutralPoseUpdate(4, neutral, make_photo().fapu)))
    assert not store.patches
    store.receive(encode_object(make_photo(4)))
    assert store.patches and store.photo is not None
    points = store.photo.warp.control_points(np.zeros((CONTROL_POINT_COUNT, 3)))
    np.testing.assert_allclose(points[0], neutral[0], atol=0.011)


@pytest.mark.slow
def test_a_new_photo_removes_the_patches_of_the_old_one() -> None:
    store = PortraitStore()
    for received in (make_photo(1), make_patch(photo_number=1), make_photo(2)):
        store.receive(encode_object(received))
    assert not store.patches


@pytest.mark.slow
def test_the_number_of_patches_is_bounded() -> None:
    store = PortraitStore()
    store.receive(encode_object(make_photo()))
    for number in range(100):
        store.receive(encode_object(make_patch(number % 2, number % MAX_SLOTS, photo_number=number % 4)))
    assert len(store.patches) <= len(FEATURES) * MAX_SLOTS


@pytest.mark.slow
def test_views_are_kept_with_their_photo_and_the_mesh_is_mapped_into_them() -> None:
    store = PortraitStore()
    store.receive(encode_object(make_view(slot=1)))
    assert not store.views, "it waits for its photo"
    store.receive(encode_object(make_photo()))
    view = store.views[1]
    assert store.photo is not None and view.pixels.shape == (240, 160, 3)
    whole = store.photo.warp.mesh.positions / (4 / 3, -1) + 0.5
    inside = store.photo.warp.on_face
    np.testing.assert_allclose(view.uvs[inside], (whole[inside] - (0.25, 0)) * (2, 1), atol=0.01)
    store.receive(encode_object(make_photo(2)))
    assert not store.views


@pytest.mark.slow
def test_a_photo_without_a_face_is_rejected_and_the_old_one_stays() -> None:
    store = PortraitStore()
    good = make_photo()
    store.receive(encode_object(good))
    before = store.photo
    assert not store.receive(encode_object(replace(good, points=good.points * 0, neutral=good.neutral * 0)))
    assert store.rejected == 1 and store.photo is before


@pytest.mark.slow
@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(0, 40))
def test_any_face_is_deformed_to_finite_positions_or_rejected(seed: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    good = make_photo()
    pose = np.concatenate([rng.uniform(-3, 3, 3), rng.uniform(-3, 3, 2), [rng.uniform(-6, 0.5)]])
    points = np.clip(good.points + rng.normal(0, spread, good.points.shape), -60, 60)
    photo = replace(good, points=points, neutral=points[:CONTROL_POINT_COUNT], pose=pose)
    store = PortraitStore()
    if store.receive(encode_object(photo)):
        assert store.photo is not None
        positions = store.photo.warp.deform(rng.normal(0, 300, (CONTROL_POINT_COUNT, 3)), POSE)
        assert np.isfinite(positions).all()
    else:
        assert store.rejected == 1


@given(st.binary(max_size=300))
def test_arbitrary_bytes_are_rejected_without_an_error(data: bytes) -> None:
    store = PortraitStore()
    store.receive(data)
    assert store.photo is None


def test_a_decoded_image_resembles_the_encoded_one() -> None:
    pixels = draw_person()
    assert np.abs(decode_image(encode_vp8(pixels)).astype(float) - pixels).mean() < 3


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_a_damaged_image_is_decoded_or_a_protocol_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = bytearray(encode_vp8(draw_person()[:64, :64]))
    for index in rng.integers(10, len(frame), 8):
        frame[index] = rng.integers(256)
    try:
        assert decode_image(bytes(frame[: rng.integers(5, len(frame) + 1)])).shape == (64, 64, 3)
    except ProtocolError:
        pass


def test_a_header_without_data_is_a_protocol_error() -> None:
    with pytest.raises(ProtocolError):
        decode_image(encode_vp8(draw_person())[:10])


@pytest.mark.slow
def test_a_background_is_shown_behind_the_person_of_its_photo_only() -> None:
    store = PortraitStore()
    green = encode_vp8(np.full((48, 64, 3), (0, 200, 0), np.uint8))
    background = Background(1, (0.25, 0.25, 0.75, 0.75), green)
    store.receive(encode_object(background))
    store.receive(encode_object(make_photo()))
    assert store.photo is not None and store.backdrop is not None, "it waited for its photo"
    behind = store.backdrop[110:130, 150:180].astype(int)
    assert np.abs(behind - (0, 200, 0)).max() < 12
    np.testing.assert_array_equal(store.backdrop[:40], store.photo.matte.backdrop[:40])
    store.receive(encode_object(make_photo(2)))
    assert store.photo is not None and store.backdrop is store.photo.matte.backdrop
