import os
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.atomic_write import partial_path
from conf.errors import RecordingError
from conf.output import video_writer
from conf.output.clip_encoder import ClipEncoder
from conf.output.video_writer import MAX_WAITING, VideoWriter
from conf.sender.capture.clip import open_clip, read_sound
from tests.output.test_clip_encoder import NAMES, ramp

Images = NDArray[np.uint8]


def times_of(path: Path) -> list[float]:
    with open_clip(path) as clip:
        return [frame.timestamp for frame in iter(clip.read, None)]


@pytest.mark.parametrize("name", NAMES)
def test_frames_follow_each_other_at_the_frame_rate(tmp_path: Path, name: str) -> None:
    with VideoWriter(tmp_path / name, fps=15) as writer:
        for _ in range(7):
            writer.write(ramp())
        assert writer.frames == 7
        assert not (tmp_path / name).exists()
    assert times_of(tmp_path / name) == pytest.approx([i / 15 for i in range(7)], abs=1e-4)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_full_path_is_returned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    writer = VideoWriter(Path("a.mp4"), fps=15)
    writer.write(ramp())
    assert writer.close() == tmp_path / "a.mp4"


def test_the_index_of_an_mp4_is_at_its_front(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", fps=15) as writer:
        writer.write(ramp())
    data = (tmp_path / "a.mp4").read_bytes()
    assert 0 < data.find(b"moov") < data.find(b"mdat")


def test_frames_of_another_size_are_scaled_to_the_first(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", fps=15) as writer:
        writer.write(ramp(64, 48))
        writer.write(ramp(128, 96))
    with open_clip(tmp_path / "a.mp4") as clip:
        assert [frame.pixels.shape for frame in iter(clip.read, None)] == [(48, 64, 3)] * 2


def test_a_video_without_frames_leaves_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.avi", fps=15) as writer:
        pass
    assert writer.close() is None
    assert not list(tmp_path.iterdir())


def write_at(path: Path, fps: float, times: list[float]) -> tuple[list[int], int]:
    """Write images at times. Returns the number of frames after each, and how many images were read."""
    reads, counts = [], []

    def read() -> Images:
        reads.append(1)
        return ramp()

    with VideoWriter(path, fps=fps) as writer:
        for now in times:
            writer.write_at(read, now)
            counts.append(writer.frames)
    return counts, len(reads)


def test_an_avi_repeats_or_leaves_out_images_to_keep_its_frame_rate(tmp_path: Path) -> None:
    assert write_at(tmp_path / "a.avi", 10, [7.0, 7.04, 7.11, 7.55]) == ([1, 1, 2, 6], 3)
    assert times_of(tmp_path / "a.avi") == pytest.approx([i / 10 for i in range(6)], abs=1e-4)


def test_an_mp4_keeps_each_image_at_its_time_and_leaves_out_those_that_come_too_soon(tmp_path: Path) -> None:
    assert write_at(tmp_path / "a.mp4", 10, [7.0, 7.04, 7.09, 7.16, 7.55]) == ([1, 1, 2, 2, 3], 3)
    assert times_of(tmp_path / "a.mp4") == pytest.approx([0.0, 0.09, 0.55], abs=1e-4)


def test_a_late_encoder_costs_frames_but_no_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    release, encode = threading.Event(), ClipEncoder.encode_frame

    def slow(encoder: ClipEncoder, pixels: Images, time: float) -> None:
        release.wait()
        encode(encoder, pixels, time)

    monkeypatch.setattr(ClipEncoder, "encode_frame", slow)
    with VideoWriter(tmp_path / "a.mp4", fps=10) as writer:
        for i in range(3 * MAX_WAITING):
            writer.write_at(ramp, i / 10)
        assert writer.frames == MAX_WAITING
        release.set()
    assert times_of(tmp_path / "a.mp4") == pytest.approx([i / 10 for i in range(MAX_WAITING)], abs=1e-4)


@pytest.mark.slow
def test_writing_every_frame_waits_for_the_encoder(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", fps=25) as writer:
        for _ in range(5 * MAX_WAITING):
            writer.write(ramp())
    assert len(times_of(tmp_path / "a.mp4")) == 5 * MAX_WAITING


def test_an_existing_file_is_kept_until_the_new_one_is_complete(tmp_path: Path) -> None:
    (tmp_path / "a.avi").write_bytes(b"old")
    writer = VideoWriter(tmp_path / "a.avi", fps=15)
    writer.write(ramp())
    assert (tmp_path / "a.avi").read_bytes() == b"old"
    writer.close()
    assert (tmp_path / "a.avi").read_bytes() != b"old"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", [KeyboardInterrupt, RecordingError])
def test_an_interrupt_or_error_keeps_the_old_file_and_names_the_partial_one_which_can_be_played(
    tmp_path: Path, kind: type[BaseException], name: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"old")
    with pytest.raises(kind) as caught, VideoWriter(path, fps=15) as writer:
        for _ in range(5):
            writer.write(ramp())
        raise kind
    assert path.read_bytes() == b"old"
    note = f"{path} is as it was before; what was written so far is in {partial_path(path)}"
    assert caught.value.__notes__ == [note]
    assert len(times_of(partial_path(path))) == 5


def test_an_interrupt_before_the_first_frame_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt) as caught, VideoWriter(tmp_path / "a.mp4", fps=15):
        raise KeyboardInterrupt
    assert not hasattr(caught.value, "__notes__") and not list(tmp_path.iterdir())


def test_an_error_of_the_encoder_is_raised_at_the_next_frame_or_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(ClipEncoder, "encode_frame", fail)
    writer = VideoWriter(tmp_path / "a.mp4", fps=15)
    writer.write(ramp())
    message = r"a\.mp4 cannot be written \(No space left on device\); choose another file or folder"
    with pytest.raises(RecordingError, match=message):
        writer.close()
    with pytest.raises(RecordingError, match=message), VideoWriter(tmp_path / "a.mp4", fps=15) as writer:
        for _ in range(2 * MAX_WAITING):
            writer.write(ramp())


def test_a_clip_ends_before_the_disk_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writer = VideoWriter(tmp_path / "a.mp4", fps=15)
    writer.write(ramp())
    monkeypatch.setattr(video_writer, "DISK_CHECK_INTERVAL", 1)
    monkeypatch.setattr("conf.output.video_writer.shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
    with pytest.raises(RecordingError, match=r"a\.mp4: the disk is full; free some space or choose another folder"):
        writer.write(ramp())
    assert writer.close() == tmp_path / "a.mp4" and len(times_of(tmp_path / "a.mp4")) == 1


def test_without_room_for_a_copy_the_index_stays_at_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(video_writer, "move_index_to_front", fail)
    with VideoWriter(tmp_path / "a.mp4", fps=15) as writer:
        writer.write(ramp())
    assert len(times_of(tmp_path / "a.mp4")) == 1 and [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def tone(seconds: float, rate: int) -> NDArray[np.int16]:
    return np.round(8000 * np.sin(2 * np.pi * 1000 * np.arange(round(seconds * rate)) / rate)).astype(np.int16)


def onsets(path: Path, rate: int) -> list[float]:
    """Return the times at which the sound begins after silence, seconds."""
    found: list[float] = []
    last_loud = -1.0
    for at, samples in read_sound(path, rate=rate):
        for i in np.flatnonzero(np.abs(samples.astype(int)) > 1500):
            time = at + i / rate
            if time - last_loud > 0.1:
                found.append(time)
            last_loud = time
    return found


@pytest.mark.slow
@pytest.mark.parametrize("rate", [16_000, 48_000])
@pytest.mark.parametrize("name", NAMES)
def test_sound_stays_in_step_with_the_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, rate: int
) -> None:
    """A flash and a tone at the same times of the call are at the same times of the clip."""
    monkeypatch.setattr(video_writer, "MAX_WAITING", 1000)  # here three seconds pass in no time
    white, black = np.full((48, 64, 3), 255, np.uint8), np.zeros((48, 64, 3), np.uint8)
    block = 0.02
    with VideoWriter(tmp_path / name, fps=25, audio_rate=rate) as writer:
        for i in range(150):
            now, is_flash = 70 + i * block, i % 50 == 25
            image = white if is_flash else black
            if i % 2 or is_flash or i == 0:
                writer.write_at(lambda image=image: image, now)  # type: ignore[misc]
            if 60 <= i < 70:
                continue  # a gap in the sound
            samples = tone(block, rate) if is_flash else np.zeros(round(block * rate), np.int16)
            writer.write_audio(samples, now)
    with open_clip(tmp_path / name) as clip:
        frames = list(iter(clip.read, None))
    flashes = [frame.timestamp for frame in frames if frame.pixels.mean() > 128]
    assert flashes[:3] == pytest.approx([0.5, 1.5, 2.5], abs=0.041)
    assert onsets(tmp_path / name, rate) == pytest.approx([0.5, 1.5, 2.5], abs=0.01)


def test_the_clocks_of_sound_and_pictures_may_differ_a_little_and_overlaps_are_cut(tmp_path: Path) -> None:
    rate = 16_000
    with VideoWriter(tmp_path / "a.mp4", fps=25, audio_rate=rate) as writer:
        writer.write_audio(tone(1.0, rate), 4.0)  # before the first picture: left out
        writer.write_at(ramp, 5.0)
        writer.write_audio(np.zeros(8000, np.int16), 4.9)  # 0.1 s of it is from before the first picture
        writer.write_audio(np.zeros(1600, np.int16), 5.43)  # 30 ms late: follows at once
        writer.write_audio(tone(0.5, rate), 5.3)  # overlaps by 0.2 s
        writer.write_at(ramp, 6.0)
    assert onsets(tmp_path / "a.mp4", rate) == pytest.approx([0.5], abs=0.01)
    samples = sum(len(samples) for _, samples in read_sound(tmp_path / "a.mp4", rate=rate))
    assert samples / rate == pytest.approx(0.8, abs=0.07)  # AAC has frames of 64 ms at this rate


def test_unsuitable_arguments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none/a\.avi cannot be written \(No such file or directory\); choose"):
        VideoWriter(tmp_path / "none" / "a.avi", fps=15)
    with pytest.raises(RecordingError, match=r"a\.mov: the name of a clip must end in \.mp4 or \.avi"):
        VideoWriter(tmp_path / "a.mov", fps=15)
    with pytest.raises(ValueError, match="fps must be positive"):
        VideoWriter(tmp_path / "a.avi", fps=0)
    with pytest.raises(ValueError, match=r"audio_rate must be one of \(16000, 48000\)"):
        VideoWriter(tmp_path / "a.mp4", fps=15, audio_rate=44100)
    with VideoWriter(tmp_path / "a.mp4", fps=15) as writer:
        with pytest.raises(ValueError, match="audio_rate must be given"):
            writer.write_audio(np.zeros(5, np.int16), 0.0)
        with pytest.raises(ValueError, match=r"samples must be \(n,\) int16, got \(5,\) float64"):
            writer.write_audio(np.zeros(5), 0.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("suffix", [".mp4", ".avi"])
@pytest.mark.parametrize("stem", [b"na\xefve", b"12:30", b"100%d", "\u00e9t\u00e9".encode()])
def test_any_file_name_can_be_written(tmp_path: Path, stem: bytes, suffix: str) -> None:
    path = tmp_path / (os.fsdecode(stem) + suffix)
    with VideoWriter(path, fps=15) as writer:
        writer.write(np.zeros((48, 64, 3), np.uint8))
    assert list(tmp_path.iterdir()) == [path] and path.stat().st_size > 100


def test_a_folder_of_the_name_is_refused_at_once_and_a_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "folder.mp4").mkdir()
    with pytest.raises(RecordingError, match=r"folder\.mp4 cannot be written \(Is a directory\); choose another"):
        VideoWriter(tmp_path / "folder.mp4", fps=15)
    (tmp_path / "link.mp4").symlink_to(tmp_path / "clip.mp4")
    with VideoWriter(tmp_path / "link.mp4", fps=15) as writer:
        writer.write(np.zeros((48, 64, 3), np.uint8))
    assert (tmp_path / "link.mp4").is_symlink() and (tmp_path / "clip.mp4").stat().st_size > 100
