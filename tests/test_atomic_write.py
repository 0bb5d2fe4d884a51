import os
from pathlib import Path

import pytest

from conf.atomic_write import atomic_write, check_writable, partial_path
from conf.errors import RecordingError


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


def test_a_link_stays_a_link_and_the_mode_of_the_file_stays(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    target, link = tmp_path / "folder" / "a.txt", tmp_path / "link.txt"
    target.write_text("old")
    target.chmod(0o600)
    link.symlink_to(target)
    with atomic_write(link) as partial:
        assert partial.parent == target.parent
        partial.write_text("new")
    assert link.is_symlink() and target.read_text() == "new" and target.stat().st_mode & 0o777 == 0o600


def test_a_device_and_a_pipe_are_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    check_writable(pipe)
    with atomic_write(pipe) as file:
        file.write_text("new")
    assert pipe.is_fifo() and os.read(reader, 10) == b"new" and list(tmp_path.iterdir()) == [pipe]
    os.close(reader)
    with atomic_write("/dev/null") as file:
        assert file == Path("/dev/null")


@pytest.mark.parametrize("name", [".", "/", "folder", "folder/.."])
def test_a_folder_is_refused_before_anything_is_written(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    with pytest.raises(IsADirectoryError), atomic_write(name):
        pass
    with pytest.raises(RecordingError, match=r"cannot be written \(Is a directory\); choose another file or folder"):
        check_writable(Path(name))


def test_what_can_be_written_is_not_changed_by_the_check(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    check_writable(path)
    check_writable(tmp_path / "new.txt")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
