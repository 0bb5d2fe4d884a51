from pathlib import Path

import pytest

from conf.atomic_write import atomic_write, partial_path


def test_a_file_appears_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with atomic_write(path) as partial:
        partial.write_text("new")
        assert partial.suffix == path.suffix and path.read_text() == "old"
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


def test_an_error_keeps_the_old_file_and_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(OSError, match="no space"), atomic_write(path) as partial:
        partial.write_text("half")
        raise OSError("no space")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_an_interrupt_keeps_the_old_file_and_names_the_partial_one(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt) as caught, atomic_write(path) as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "old" and partial_path(path).read_text() == "half"
    assert caught.value.__notes__ == [f"{path} is as it was before; what was written so far is in {partial_path(path)}"]


def test_a_first_file_that_is_interrupted_is_named_too(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt) as caught, atomic_write(tmp_path / "b.txt") as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert caught.value.__notes__ == [f"what was written so far is in {tmp_path / 'b.partial.txt'}"]


def test_a_folder_that_is_not_there_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(tmp_path / "none" / "a.txt") as partial:
        partial.write_text("x")
