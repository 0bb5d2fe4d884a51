"""Write files whole or not at all: beside the target first, then renamed."""

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from conf.errors import ConfError, RecordingError

_ADVICE = "choose another file or folder"


@contextmanager
def atomic_write(path: Path | str, /) -> Iterator[Path]:
    """Yield a path beside `path` to write to; when the block ends it replaces `path` in one step.

    On an error the partial file is removed and `path` stays as it was. On an interrupt (Ctrl-C) the partial file is
    kept and named in a note of the exception. A link stays a link; a device or pipe is written to, never replaced.
    Raises OSError if the folder cannot be written, or `path` is one.
    """
    path = write_target(Path(path))
    if _is_special(path):
        yield path
        return
    partial = partial_path(path)
    try:
        yield partial
        with contextlib.suppress(OSError):
            shutil.copymode(path, partial)
        partial.replace(path)
    except Exception:
        partial.unlink(missing_ok=True)
        raise
    except BaseException as interrupt:
        if partial.exists():
            interrupt.add_note(interrupted_note(path))
        raise


def check_writable(path: Path, /, *, advice: str = _ADVICE) -> None:
    """Check, before long work, that a file can be written. Raises RecordingError with the advice."""
    with report_write_errors(path, RecordingError, advice=advice):
        target = write_target(path)
        if not _is_special(target):
            partial = partial_path(target)
            partial.touch()
            partial.unlink()


def write_target(path: Path, /) -> Path:
    """Return the file that is written for a path; for a link, the file it leads to. Raises OSError for a folder."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    return path if _is_special(path) else path.resolve()


def _is_special(path: Path) -> bool:
    """Return whether a path is a device, a pipe or a socket."""
    return path.exists() and not path.is_file()


@contextmanager
def report_write_errors(
    path: object, error_type: type[ConfError] = ConfError, *, advice: str = _ADVICE
) -> Iterator[None]:
    """Raise an OSError inside the block, which writes `path`, as a ConfError with the advice."""
    try:
        yield
    except OSError as error:
        raise error_type(f"{path} cannot be written ({error.strerror}); {advice}") from error


def partial_path(path: Path, /) -> Path:
    """Return the name under which a file is written until it is whole; its suffix is the same."""
    return path.with_name(f"{path.stem}.partial{path.suffix}")


def interrupted_note(path: Path, /) -> str:
    """Return what to tell the user of a file whose writing was interrupted."""
    kept = f"{path} is as it was before; " if path.exists() else ""
    return f"{kept}what was written so far is in {partial_path(path)}"
