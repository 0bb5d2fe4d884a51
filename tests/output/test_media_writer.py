from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import RecordingError
from conf.output.media_writer import VideoWriter, next_free_path, save_image


def ramp(width: int = 64, height: int = 48) -> NDArray[np.uint8]:
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[..., 0] = np.linspace(0, 255, width)
    pixels[..., 2] = np.linspace(0, 255, height)[:, None]
    return pixels


@pytest.mark.parametrize(("suffix", "error"), [(".jpg", 12), (".JPG", 12), (".png", 0)])
def test_an_image_is_read_back_unchanged(tmp_path: Path, suffix: str, error: int) -> None:
    path = save_image(tmp_path / f"a{suffix}", ramp())
    pixels = cv2.imread(str(path))
    assert pixels is not None
    np.testing.assert_allclose(pixels.astype(int), ramp().astype(int), atol=error)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a.avi", "a.mp4"])
def test_a_video_has_its_frames_frame_rate_and_size(tmp_path: Path, name: str) -> None:
    with VideoWriter(tmp_path / name, fps=15) as writer:
        for _ in range(7):
            writer.write(ramp())
        assert writer.frames == 7
        assert not (tmp_path / name).exists()
    clip = cv2.VideoCapture(str(tmp_path / name))
    assert clip.get(cv2.CAP_PROP_FPS) == pytest.approx(15)
    frames = []
    while (read := clip.read())[0]:
        frames.append(read[1])
    assert len(frames) == 7
    np.testing.assert_allclose(frames[3].astype(int), ramp().astype(int), atol=24)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_frames_of_another_size_are_scaled_to_the_first(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.avi", fps=15) as writer:
        writer.write(ramp(65, 49))
        writer.write(ramp(130, 98))
    clip = cv2.VideoCapture(str(tmp_path / "a.avi"))
    shapes = [clip.read()[1].shape for _ in range(2)]
    assert shapes[0] == shapes[1]


def test_a_video_without_frames_leaves_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.avi", fps=15) as writer:
        pass
    assert writer.close() is None
    assert not list(tmp_path.iterdir())


def test_images_at_uneven_times_are_repeated_or_left_out_to_keep_the_frame_rate(tmp_path: Path) -> None:
    reads = []

    def read() -> NDArray[np.uint8]:
        reads.append(1)
        return ramp()

    with VideoWriter(tmp_path / "a.avi", fps=10) as writer:
        for now, frames in [(7.0, 1), (7.04, 1), (7.11, 2), (7.55, 6)]:
            writer.write_at(read, now)
            assert writer.frames == frames
    assert len(reads) == 3


def test_an_existing_file_is_kept_until_the_new_one_is_complete(tmp_path: Path) -> None:
    (tmp_path / "a.avi").write_bytes(b"old")
    writer = VideoWriter(tmp_path / "a.avi", fps=15)
    writer.write(ramp())
    assert (tmp_path / "a.avi").read_bytes() == b"old"
    writer.close()
    assert (tmp_path / "a.avi").read_bytes() != b"old"


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none/a\.jpg cannot be written \(No such file or directory\); choose"):
        save_image(tmp_path / "none" / "a.jpg", ramp())
    with pytest.raises(RecordingError, match=r"none/a\.avi cannot be written \(No such file or directory\); choose"):
        VideoWriter(tmp_path / "none" / "a.avi", fps=15)


def test_an_unknown_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a\.gif: the name must end in \.jpg or \.jpeg or \.png"):
        save_image(tmp_path / "a.gif", ramp())
    with pytest.raises(RecordingError, match=r"a\.mov: the name must end in \.avi or \.mp4"):
        VideoWriter(tmp_path / "a.mov", fps=15)
    with pytest.raises(ValueError, match="fps must be positive"):
        VideoWriter(tmp_path / "a.avi", fps=0)


def test_free_names_count_up(tmp_path: Path) -> None:
    (tmp_path / "conf-001.jpg").touch()
    assert next_free_path(tmp_path, "conf", ".jpg").name == "conf-002.jpg"
    assert next_free_path(tmp_path, "conf", ".avi").name == "conf-001.avi"
