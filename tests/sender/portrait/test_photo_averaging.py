import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.photo_averaging import FRAMES_PER_STEP, MeshAligner, average_steps, barycentric_weights
from conf.sender.portrait.recent_frames import RecentFrame
from tests.support.drawn_person import SIZE, draw_person
from tests.support.portrait_subjects import motion, recent_frame
from tests.support.synthetic_portrait import POSE, face_shape


def noisy(seed: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(seed).normal(0, 12, (SIZE[1], SIZE[0], 3))
    return np.clip(draw_person() + noise, 0, 255).astype(np.uint8)


def averaged(photo: NDArray[np.uint8], frames: list[RecentFrame]) -> tuple[NDArray[np.uint8], int]:
    warp = PortraitWarp(face_shape())
    *before, result = average_steps(photo, warp, warp.mesh.positions, frames)
    assert result is not None
    return result, len(before)


@pytest.mark.slow
def test_the_average_of_noisy_frames_is_nearer_to_the_face() -> None:
    frames = [recent_frame(noisy(seed)) for seed in range(1, 7)]
    result, steps = averaged(noisy(0), frames)
    face = slice(90, 160), slice(130, 200)
    before, after = (np.abs(image[face].astype(float) - draw_person()[face]).mean() for image in (noisy(0), result))
    assert after < 0.7 * before and steps == 1 + len(frames) // FRAMES_PER_STEP


@pytest.mark.slow
def test_what_differs_from_the_photo_has_little_weight() -> None:
    covered = draw_person()
    covered[100:160, 130:200] = (0, 255, 0)
    result, _ = averaged(draw_person(), [recent_frame(covered)] * 4)
    assert np.abs(result.astype(float) - draw_person())[100:160, 130:200].mean() < 8


@pytest.mark.slow
def test_a_frame_in_which_the_head_has_moved_is_moved_back() -> None:
    warp = PortraitWarp(face_shape())
    pose = HeadPose(POSE.rotation, POSE.position + np.array([0.1, 0.0]), POSE.log_scale)
    moved = np.roll(draw_person(), 24, axis=1)
    aligned, weight, offset = MeshAligner(warp, warp.mesh.positions, SIZE).align(
        draw_person(), recent_frame(moved, motion(pose=pose))
    )
    face = slice(100, 150), slice(140, 190)
    assert np.abs(aligned[face] - draw_person()[face]).mean() < 6 and weight[face].mean() > 0.7
    assert np.abs(offset[face]).mean() < 1


@pytest.mark.slow
def test_the_average_is_where_the_skin_is_in_the_mean_of_the_frames() -> None:
    shifted = np.roll(draw_person(), 3, axis=1)  # by the tracker the face has not moved
    result, _ = averaged(draw_person(), [recent_frame(shifted)] * 6)
    face = slice(100, 150), slice(140, 190)
    before, after = (np.abs(result[face].astype(float) - image[face]).mean() for image in (draw_person(), shifted))
    assert after < 0.5 * before
    np.testing.assert_array_equal(result[:60, :40], draw_person()[:60, :40])


@pytest.mark.slow
def test_frames_of_another_size_are_ignored() -> None:
    result, _ = averaged(draw_person(), [recent_frame(draw_person()[::2, ::2])])
    np.testing.assert_array_equal(result, draw_person())


def test_weights_interpolate_between_the_corners_of_a_triangle() -> None:
    positions = np.array([(-0.4, -0.4), (0.5, -0.4), (-0.4, 0.5)])
    weights, inside = barycentric_weights(positions, np.array([[0, 1, 2]], np.int32), (40, 40))
    pixels = (weights @ (positions * (40, -40) + 20 - 0.5)).reshape(40, 40, 2)
    assert inside.mean() == pytest.approx(0.405, abs=0.05)
    y, x = np.nonzero(inside)
    np.testing.assert_allclose(pixels[inside], np.column_stack([x, y]), atol=1e-9)
