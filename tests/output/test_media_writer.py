from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import RecordingError
from conf.output.media_writer import VideoWriter, next_free_path, save_picture


def ramp(width: int = 64, height: int = 48) -> NDArray[np.uint8]:
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[..., 0] = np.linspace(0, 255, width)
    pixels[..., 2] = np.linspace(0, 255, height)[:, None]
    return pixels


@pytest.mark.parametrize(("suffix", "error"), [(".jpg", 12), (".JPG", 12), (".png", 0)])
def test_a_picture_is_read_back_as_it_was(tmp_path: Path, suffix: str, error: int) -> None:
    path = save_picture(tmp_path / f"a{suffix}", ramp())
    np.testing.assert_allclose(cv2.imread(str(path)).astype(int), ramp().astype(int), atol=error)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a.avi", "a.mp4"])
def test_a_clip_has_its_frames_rate_and_size(tmp_path: Path, name: str) -> None:
    with VideoWriter(tmp_path / name, fps=15) as recorder:
        for _ in range(7):
            recorder.write(ramp())
        assert recorder.frames == 7
        assert not (tmp_path / name).exists()
    clip = cv2.VideoCapture(str(tmp_path / name))
    assert clip.get(cv2.CAP_PROP_FPS) == pytest.approx(15)
    frames = []
    while (read := clip.read())[0]:
        frames.append(read[1])
    assert len(frames) == 7
    np.testing.assert_allclose(frames[3].astype(int), ramp().astype(int), atol=24)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_pictures_of_another_size_are_scaled_to_the_first(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.avi", fps=15) as recorder:
        recorder.write(ramp(65, 49))
        recorder.write(ramp(130, 98))
    clip = cv2.VideoCapture(str(tmp_path / "a.avi"))
    shapes = [clip.read()[1].shape for _ in range(2)]
    assert shapes[0] == shapes[1]


def test_a_clip_without_pictures_leaves_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.avi", fps=15) as recorder:
        pass
    assert recorder.close() is None
    assert not list(tmp_path.iterdir())


def test_what_was_there_is_kept_until_the_new_clip_is_whole(tmp_path: Path) -> None:
    (tmp_path / "a.avi").write_bytes(b"old")
    recorder = VideoWriter(tmp_path / "a.avi", fps=15)
    recorder.write(ramp())
    assert (tmp_path / "a.avi").read_bytes() == b"old"
    recorder.close()
    assert (tmp_path / "a.avi").read_bytes() != b"old"


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none/a\.jpg cannot be written \(No such file or directory\); choose"):
        save_picture(tmp_path / "none" / "a.jpg", ramp())
    with pytest.raises(RecordingError, match=r"none/a\.avi cannot be written \(No such file or directory\); choose"):
        VideoWriter(tmp_path / "none" / "a.avi", fps=15)


def test_a_format_that_is_not_known_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a\.gif: the name must end in \.jpg or \.jpeg or \.png"):
        save_picture(tmp_path / "a.gif", ramp())
    with pytest.raises(RecordingError, match=r"a\.mov: the name must end in \.avi or \.mp4"):
        VideoWriter(tmp_path / "a.mov", fps=15)
    with pytest.raises(ValueError, match="fps must be positive"):
        VideoWriter(tmp_path / "a.avi", fps=0)


def test_names_count_up(tmp_path: Path) -> None:
    (tmp_path / "conf-001.jpg").touch()
    assert next_free_path(tmp_path, "conf", ".jpg").name == "conf-002.jpg"
    assert next_free_path(tmp_path, "conf", ".avi").name == "conf-001.avi"
