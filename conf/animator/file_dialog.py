"""The desktop's file dialogs, opened beside the window, which goes on drawing while one is open.

On Linux they are programs of the desktop: without one of these, or without a display, a path can only be typed.
"""

import os
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from imgui_bundle import portable_file_dialogs

PROGRAMS = ("zenity", "matedialog", "qarma", "kdialog")  # those that portable-file-dialogs knows
NOT_AVAILABLE = "no file dialog is installed: install zenity or kdialog, or type the path into the field"


class Dialog(Protocol):
    """An open dialog, as portable-file-dialogs has it. result : one path, a list of one, or empty if cancelled"""

    def ready(self, timeout: int) -> bool: ...

    def result(self) -> str | list[str]: ...

    def kill(self) -> bool: ...


@dataclass(frozen=True)
class FileRequest:
    """What a dialog asks for.

    purpose : returned with the chosen file
    start : the file or folder that the dialog shows first
    suffixes : of the files to choose from, described by `kind`
    save : whether a new file may be named
    """

    purpose: str
    title: str
    start: Path
    kind: str
    suffixes: Sequence[str]
    save: bool = False


def has_dialogs() -> bool:
    """Tell whether this machine can open a file dialog."""
    if sys.platform in ("win32", "darwin"):
        return True
    has_display = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return has_display and any(shutil.which(program) for program in PROGRAMS)


def open_dialog(request: FileRequest) -> Dialog:
    """Open a dialog of the desktop."""
    # Upper case too: the filter is compared letter by letter.
    patterns = " ".join(f"*{suffix} *{suffix.upper()}" for suffix in request.suffixes)
    filters = [request.kind, patterns, "all files", "*"]
    make = portable_file_dialogs.save_file if request.save else portable_file_dialogs.open_file
    return make(request.title, str(request.start), filters)


class FileDialog:
    """At most one open dialog."""

    def __init__(
        self,
        *,
        is_available: Callable[[], bool] = has_dialogs,
        open_dialog: Callable[[FileRequest], Dialog] = open_dialog,
    ) -> None:
        self._is_available, self._open_dialog = is_available, open_dialog
        self._open: tuple[FileRequest, Dialog] | None = None

    @property
    def is_open(self) -> bool:
        """Whether a dialog waits for the user."""
        return self._open is not None

    def open(self, request: FileRequest) -> str:
        """Open a dialog. Returns why that is not possible, empty if it is open."""
        if self._open is not None:
            return "a file dialog is open already: it may be behind this window"
        if not self._is_available():
            return NOT_AVAILABLE
        self._open = request, self._open_dialog(request)
        return ""

    def poll(self) -> tuple[FileRequest, Path] | None:
        """Return a request and the file that was chosen for it, once; None while the user has not chosen."""
        if self._open is None or not self._open[1].ready(0):
            return None
        (request, dialog), self._open = self._open, None
        result = dialog.result()
        chosen = (result[0] if result else "") if isinstance(result, list) else result
        if not chosen:
            return None
        path = Path(chosen)
        if request.save and path.suffix.lower() not in request.suffixes:
            path = Path(f"{chosen}{request.suffixes[0]}")
        return request, path

    def close(self) -> None:
        """Close the dialog that is open."""
        if self._open is not None:
            self._open[1].kill()
            self._open = None
