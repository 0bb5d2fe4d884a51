from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import RecordingError
from conf.output.image_writer import next_free_path, save_image


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


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none/a\.jpg cannot be written \(No such file or directory\); choose"):
        save_image(tmp_path / "none" / "a.jpg", ramp())


def test_an_unknown_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a\.gif: the name of an image must end in \.jpg, \.jpeg, \.png"):
        save_image(tmp_path / "a.gif", ramp())


def test_the_path_is_returned_in_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert save_image(Path("a.png"), ramp()) == tmp_path / "a.png"
    assert next_free_path(Path(), "conf", ".mp4") == tmp_path / "conf-001.mp4"


def test_free_names_count_up_and_spare_what_is_being_written(tmp_path: Path) -> None:
    (tmp_path / "conf-001.jpg").touch()
    assert next_free_path(tmp_path, "conf", ".jpg").name == "conf-002.jpg"
    assert next_free_path(tmp_path, "conf", ".avi").name == "conf-001.avi"
    (tmp_path / "conf-001.partial.avi").touch()
    assert next_free_path(tmp_path, "conf", ".avi").name == "conf-002.avi"
