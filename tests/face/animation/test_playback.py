import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.interpolate import PchipInterpolator

from conf.face.animation.playback import (
    SPEEDS,
    PlaybackClock,
    displacements_at,
    duration_of,
    interpolate_frames,
    pose_at,
)
from conf.face.formats.dpc import MotionClip

numbers = st.floats(-1000, 1000, allow_subnormal=False).map(lambda x: round(x, 3))
tracks = hnp.arrays(np.float64, st.tuples(st.integers(1, 12), st.just(3)), elements=numbers)


@pytest.mark.slow
@given(frames=tracks, position=st.floats(-2, 14))
def test_interpolation_does_not_overshoot(frames: np.ndarray, position: float) -> None:
    value = interpolate_frames(frames, position)
    i = int(np.clip(np.floor(position), 0, max(len(frames) - 2, 0)))
    pair = frames[i : i + 2]
    slack = 1e-9 * (1 + np.abs(frames).max())
    assert (value >= pair.min(axis=0) - slack).all()
    assert (value <= pair.max(axis=0) + slack).all()


@pytest.mark.slow
@given(frames=tracks)
def test_interpolation_passes_through_every_frame(frames: np.ndarray) -> None:
    for i, frame in enumerate(frames):
        np.testing.assert_allclose(interpolate_frames(frames, i), frame, atol=1e-9)


@pytest.mark.slow
@given(frames=hnp.arrays(np.float64, (8, 2), elements=numbers), position=st.floats(1, 6))
def test_interpolation_equals_scipy_inside(frames: np.ndarray, position: float) -> None:
    # SciPy estimates the slopes at the two ends, ours are 0: the outermost intervals differ.
    expected = PchipInterpolator(np.arange(8), frames)(position)
    np.testing.assert_allclose(interpolate_frames(frames, position), expected, atol=1e-6)


@pytest.mark.slow
def test_interpolation_is_smooth_at_frames() -> None:
    frames = np.random.default_rng(3).normal(size=(9, 50, 3))
    positions = np.linspace(0, 8, 8001)
    values = np.array([interpolate_frames(frames, position) for position in positions])
    speeds = np.diff(values, axis=0) / np.diff(positions)[:, None, None]
    assert np.abs(np.diff(speeds, axis=0)).max() < 0.1


def test_displacements_and_pose_at_a_position() -> None:
    motion = MotionClip(
        10.0, "fapu", np.arange(6, dtype=np.float32).reshape(3, 2, 1).repeat(3, axis=2), np.zeros((3, 6))
    )
    assert duration_of(motion) == pytest.approx(0.2)
    np.testing.assert_allclose(displacements_at(motion, 0.1), motion.displacements[1])
    np.testing.assert_allclose(displacements_at(motion, 9.0), motion.displacements[2])
    assert displacements_at(motion, 0.0).dtype == np.float32
    assert pose_at(motion, 0.1).shape == (6,)  # type: ignore[union-attr]
    assert pose_at(MotionClip(10.0, "fapu", motion.displacements), 0.1) is None


def test_a_clock_starts_pauses_resumes_and_stops() -> None:
    clock = PlaybackClock(10.0)
    assert clock.position(5.0) == 0.0 and not clock.is_playing(5.0)
    clock.start(5.0)
    assert clock.position(7.0) == 2.0 and clock.is_playing(7.0)
    clock.pause(7.0)
    assert clock.position(99.0) == 2.0 and not clock.is_playing(99.0)
    clock.resume(100.0)
    assert clock.position(101.0) == 3.0
    clock.stop(102.0)
    assert clock.position(103.0) == 0.0


def test_speed_changes_and_seeks_are_continuous() -> None:
    clock = PlaybackClock(10.0)
    clock.start(0.0)
    clock.set_speed(0.5, 2.0)
    assert clock.position(2.0) == 2.0
    assert clock.position(4.0) == 3.0
    clock.seek(8.0, 4.0)
    assert clock.position(5.0) == 8.5
    clock.set_speed(100.0, 5.0)
    assert clock.speed == SPEEDS[1]
    clock.seek(-3.0, 5.0)
    assert clock.position(5.0) == 0.0


def test_the_clock_stops_at_the_end_or_loops() -> None:
    clock = PlaybackClock(2.0)
    clock.start(0.0)
    assert clock.position(9.0) == 2.0 and not clock.is_playing(9.0)
    clock.resume(10.0)
    assert clock.position(10.5) == 0.5
    looped = PlaybackClock(2.0, loop=True)
    looped.start(0.0)
    assert looped.position(5.0) == pytest.approx(1.0) and looped.is_playing(5.0)


def test_steps_stop_on_frames() -> None:
    clock = PlaybackClock(1.0)
    clock.start(0.0)
    clock.step(1, 10.0, 0.25)  # between frames 2 and 3
    assert clock.position(9.0) == pytest.approx(0.3)
    clock.step(-1, 10.0, 9.0)
    assert clock.position(9.0) == pytest.approx(0.2)
    clock.step(-9, 10.0, 9.0)
    assert clock.position(9.0) == 0.0
    clock.step(99, 10.0, 9.0)
    assert clock.position(9.0) == 1.0


commands = st.lists(
    st.tuples(st.sampled_from(["start", "pause", "resume", "stop", "seek", "speed", "step"]), st.floats(-20, 20)),
    max_size=12,
)


@pytest.mark.slow
@given(duration=st.floats(0, 20), loop=st.booleans(), commands=commands)
def test_the_position_is_within_the_recording_after_any_commands(
    duration: float, loop: bool, commands: list[tuple[str, float]]
) -> None:
    clock, now = PlaybackClock(duration, loop=loop), 0.0
    for name, value in commands:
        match name:
            case "seek":
                clock.seek(value, now)
            case "speed":
                clock.set_speed(value, now)
            case "step":
                clock.step(int(value), 15.0, now)
            case _:
                getattr(clock, name)(now)
        now += abs(value)
        assert 0.0 <= clock.position(now) <= duration


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_an_invalid_duration_is_an_error(duration: float) -> None:
    with pytest.raises(ValueError, match="duration must be"):
        PlaybackClock(duration)
