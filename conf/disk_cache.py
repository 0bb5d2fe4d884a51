"""Cache of results on the user's disk: objects that take long to make are read the second time.

Strategy. An object is made of dataclasses, arrays, tuples, lists, dictionaries, paths, numbers and texts. It is written
as MessagePack with a checksum in front, and only the dataclasses that the caller names are made again when it is read:
nothing in a file is executed. If the folder cannot be written, or a file in it is damaged, the object is made again.
"""

import contextlib
import hashlib
import os
import zlib
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgpack
import numpy as np
import platformdirs

from conf import __version__

T = TypeVar("T")

_CHECKSUM = 4  # bytes in front of a file
_MAX_FILES = 16  # of a folder; those of a head of 20,000 vertices have 8 MB
_MAX_BYTES = 1 << 28
_KIND = "kind"  # of a dictionary that stands for what MessagePack does not have; its content is under "value"


def cache_folder(name: str) -> Path:
    """Return the folder of one kind of results; it may not exist."""
    return Path(platformdirs.user_cache_dir("conf", appauthor=False)) / name


def cache_key(*parts: object) -> str:
    """Return the SHA-256 of the parts, in hex: arrays, bytes, or objects by their repr."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            part = part.tobytes()
        data = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(f"{len(data)};".encode())
        digest.update(data)
    return digest.hexdigest()


def file_state(part: object) -> object:
    """Return what to make a key of in place of a path: with the size in bytes and the time of change in ns of its file.

    Anything else is returned unchanged.
    """
    if not isinstance(part, Path):
        return part
    try:
        status = part.stat()
    except OSError:
        return str(part)
    return str(part), status.st_size, status.st_mtime_ns


def folder_state(folder: Path, pattern: str) -> list[object]:
    """Return the states of the files below a folder, to notice that one of them has changed."""
    return [file_state(path) for path in sorted(folder.rglob(pattern))]


def source_state(package: str) -> tuple[object, ...]:
    """Return what changes whenever the code of a package of conf does: the program's version, the state of its files.

    package : such as "face"; as a part of a key it makes results of another version unknown
    """
    return __version__, folder_state(Path(__file__).with_name(package), "*.py")


def cached(name: str, key: str, make: Callable[[], T], /, *classes: type) -> T:
    """Return the object that is cached under a key, or make and cache it.

    name : of the folder
    classes : the dataclasses that the object consists of
    """
    path = cache_folder(name) / key
    found = _read(path, {kind.__name__: kind for kind in classes})
    if found is None:
        found = make()
        _write(path, found)
    return found  # type: ignore[no-any-return]  # what the key stands for


def _read(path: Path, classes: dict[str, type]) -> Any:
    """Return the object in a file, None if it is missing or damaged."""
    try:
        if path.stat().st_size > _MAX_BYTES:
            return None
        data = memoryview(path.read_bytes())
        if zlib.crc32(data[_CHECKSUM:]) != int.from_bytes(data[:_CHECKSUM], "big"):
            return None
        return _from_plain(msgpack.unpackb(data[_CHECKSUM:]), classes)
    except (OSError, ValueError, TypeError, KeyError, MemoryError, RecursionError):
        return None


def _write(path: Path, value: object) -> None:
    data = msgpack.packb(_to_plain(value))
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(zlib.crc32(data).to_bytes(_CHECKSUM, "big") + data)
        temporary.replace(path)  # the file appears complete or not at all
        files = [file for file in path.parent.iterdir() if not file.suffix]
        for old in sorted(files, key=lambda file: file.stat().st_mtime)[:-_MAX_FILES]:
            old.unlink()
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink()


def _to_plain(value: Any) -> Any:
    """Return an object as MessagePack knows it."""
    if value is None or isinstance(value, (bool, int, float, str, bytes)):
        return value
    if isinstance(value, list):
        return [_to_plain(item) for item in value]
    match value:
        case np.ndarray():
            plain: Any = [value.dtype.str, value.shape, value.tobytes()]
        case np.generic():
            return value.item()
        case tuple():
            plain = [_to_plain(item) for item in value]
        case dict():
            plain = [[_to_plain(name), _to_plain(item)] for name, item in value.items()]
        case Path():
            plain = str(value)
        case _ if is_dataclass(value):
            plain = [_to_plain(getattr(value, field.name)) for field in fields(value)]
        case _:
            raise TypeError(f"a {type(value).__name__} cannot be cached")
    kind = next((base for base in (np.ndarray, tuple, dict, Path) if isinstance(value, base)), type(value))
    return {_KIND: kind.__name__, "value": plain}


def _from_plain(plain: Any, classes: dict[str, type]) -> Any:
    """Return the object that `_to_plain` was given. Raises KeyError, TypeError or ValueError if there is none."""
    if isinstance(plain, list):
        return [_from_plain(item, classes) for item in plain]
    if not isinstance(plain, dict):
        return plain
    kind, value = plain[_KIND], plain["value"]
    match kind:
        case "ndarray":
            dtype, shape, data = value
            return np.frombuffer(bytearray(data), np.dtype(dtype)).reshape(shape)
        case "tuple":
            return tuple(_from_plain(value, classes))
        case "dict":
            return dict(_from_plain(value, classes))
        case "Path":
            return Path(value)
        case _:
            return classes[kind](*_from_plain(value, classes))
