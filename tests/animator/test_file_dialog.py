import os
import sys
from pathlib import Path

import pytest

from conf.animator.file_dialog import NOT_AVAILABLE, FileDialog, FileRequest, has_dialogs, open_dialog

LOAD = FileRequest("points", "Load", Path("/somewhere"), "control points", (".ppc",))
SAVE = FileRequest("saved points", "Save", Path("/somewhere/a.ppc"), "control points", (".ppc",), save=True)


class FakeDialog:
    """A dialog whose user has not answered until `answer` is set."""

    def __init__(self) -> None:
        self.answer: str | list[str] | None = None
        self.killed = False

    def ready(self, timeout: int) -> bool:
        assert timeout == 0, "the window must not wait"
        return self.answer is not None

    def result(self) -> str | list[str]:
        assert self.answer is not None
        return self.answer

    def kill(self) -> bool:
        self.killed = True
        return True


def test_a_chosen_file_is_returned_once_with_its_request() -> None:
    fake = FakeDialog()
    dialog = FileDialog(is_available=lambda: True, open_dialog=lambda request: fake)
    assert dialog.poll() is None and not dialog.is_open
    assert dialog.open(LOAD) == "" and dialog.is_open
    assert dialog.poll() is None
    assert dialog.open(SAVE) == "a file dialog is open already: it may be behind this window"
    fake.answer = ["/somewhere/b.ppc"]
    assert dialog.poll() == (LOAD, Path("/somewhere/b.ppc"))
    assert dialog.poll() is None and not dialog.is_open


@pytest.mark.parametrize(("request_", "answer"), [(LOAD, []), (SAVE, "")])
def test_a_cancelled_dialog_chooses_nothing(request_: FileRequest, answer: str | list[str]) -> None:
    fake = FakeDialog()
    dialog = FileDialog(is_available=lambda: True, open_dialog=lambda request: fake)
    dialog.open(request_)
    fake.answer = answer
    assert dialog.poll() is None and not dialog.is_open


@pytest.mark.parametrize(("named", "path"), [("/a/b", "/a/b.ppc"), ("/a/b.PPC", "/a/b.PPC"), ("/a/b.c", "/a/b.c.ppc")])
def test_a_file_to_save_gets_its_suffix(named: str, path: str) -> None:
    fake = FakeDialog()
    dialog = FileDialog(is_available=lambda: True, open_dialog=lambda request: fake)
    dialog.open(SAVE)
    fake.answer = named
    assert dialog.poll() == (SAVE, Path(path))


def test_without_a_dialog_program_the_user_reads_why() -> None:
    def never(request: FileRequest) -> FakeDialog:
        raise AssertionError("no dialog can be opened")

    dialog = FileDialog(is_available=lambda: False, open_dialog=never)
    assert dialog.open(LOAD) == NOT_AVAILABLE and "type the path" in NOT_AVAILABLE
    assert not dialog.is_open


def test_closing_ends_the_dialog() -> None:
    fake = FakeDialog()
    dialog = FileDialog(is_available=lambda: True, open_dialog=lambda request: fake)
    dialog.close()
    dialog.open(LOAD)
    dialog.close()
    assert fake.killed and not dialog.is_open


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="there the system has dialogs")
def test_a_dialog_needs_a_program_and_a_display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program = tmp_path / "zenity"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":9")
    assert has_dialogs()
    monkeypatch.delenv("DISPLAY")
    assert not has_dialogs()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert has_dialogs()
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    assert not has_dialogs()


def test_the_library_gets_title_start_and_filters(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[tuple[object, ...]] = []
    library = "conf.animator.file_dialog.portable_file_dialogs"
    monkeypatch.setattr(f"{library}.open_file", lambda *values: opened.append(("open", *values)))
    monkeypatch.setattr(f"{library}.save_file", lambda *values: opened.append(("save", *values)))
    open_dialog(LOAD)
    open_dialog(SAVE)
    filters = ["control points", "*.ppc *.PPC", "all files", "*"]
    assert opened == [
        ("open", "Load", os.fspath(LOAD.start), filters),
        ("save", "Save", os.fspath(SAVE.start), filters),
    ]
