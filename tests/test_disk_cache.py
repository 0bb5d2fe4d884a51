import hashlib
import os
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from conf.disk_cache import cache_folder, cache_key, cached, file_state, folder_state, source_state


@dataclass(frozen=True)
class Part:
    number: int
    array: Any


@dataclass(frozen=True)
class Whole:
    name: str
    parts: tuple[Part, ...]
    groups: dict[str, list[float]]
    file: Path


WHOLE = Whole(
    "a", (Part(1, np.arange(6, dtype=np.float32).reshape(2, 3)), Part(2, None)), {"b": [0.5]}, Path("c/d.png")
)


@pytest.fixture(autouse=True)
def _empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def maker(made: Any = WHOLE) -> tuple[Callable[[], Any], list[int]]:
    calls: list[int] = []

    def make() -> Any:
        calls.append(1)
        return made

    return make, calls


def read(made: Any = WHOLE, key: str = "key") -> tuple[Any, int]:
    """Return what is cached under the key, and how often it was made for it."""
    make, calls = maker(made)
    return cached("things", key, make, Whole, Part), len(calls)


def test_an_object_is_made_once_and_read_again_as_it_was() -> None:
    assert read() == (WHOLE, 1)
    found, made = read()
    assert made == 0 and (found.name, found.groups, found.file) == (WHOLE.name, WHOLE.groups, WHOLE.file)
    assert [part.number for part in found.parts] == [1, 2] and found.parts[1].array is None
    array = found.parts[0].array
    assert array.dtype == np.float32 and array.tolist() == WHOLE.parts[0].array.tolist()
    array += 1  # it may be changed


def framed(content: object) -> bytes:
    """Return a file with a right checksum."""
    data = msgpack.packb(content)
    return zlib.crc32(data).to_bytes(4, "big") + data


@pytest.mark.parametrize(
    "damage",
    [
        b"",
        b"\x00\x00\x00\x00",
        b"not an object",
        bytes(1000),
        framed({"kind": "Other", "value": []}),
        framed({"kind": "Part", "value": [1]}),
        framed({"kind": "ndarray", "value": ["<f4", [5], b"1234"]}),
        framed({"kind": "ndarray", "value": ["O", [1], b"12345678"]}),
        framed({"value": 1}),
        None,
    ],
    ids=["empty", "checksum", "text", "zeros", "class", "fields", "shape", "objects", "no kind", "folder"],
)
def test_a_damaged_file_is_replaced(damage: bytes | None) -> None:
    path = cache_folder("things") / "key"
    path.parent.mkdir(parents=True)
    if damage is None:
        path.mkdir()
    else:
        path.write_bytes(damage)
    assert read() == (WHOLE, 1)


def test_every_changed_byte_is_noticed() -> None:
    read()
    path = cache_folder("things") / "key"
    data = path.read_bytes()
    for at in range(0, len(data), 7):
        path.write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
        assert read()[1] == 1


def test_what_cannot_be_written_is_a_fault_of_the_program() -> None:
    with pytest.raises(TypeError, match="a set cannot be cached"):
        read({1, 2})


def test_numbers_of_numpy_become_pythons() -> None:
    read([np.float64(0.5), np.int32(3)], "numbers")
    assert read([], "numbers") == ([0.5, 3], 0)


def test_the_folder_is_the_user_s(tmp_path: Path) -> None:
    assert cache_folder("things") == tmp_path / "conf" / "things"


def test_an_unwritable_cache_is_ignored(tmp_path: Path) -> None:
    (tmp_path / "conf").write_text("a file where the folder should be")
    assert [read(), read()] == [(WHOLE, 1)] * 2


def test_the_oldest_files_are_removed_whatever_their_names() -> None:
    for i in range(16):
        read(key=f"key{99 - i}")
        os.utime(cache_folder("things") / f"key{99 - i}", (i, i))
    read(key="another")
    assert {path.name for path in cache_folder("things").iterdir()} == {
        "another",
        *(f"key{99 - i}" for i in range(1, 16)),
    }


def test_every_part_changes_the_key() -> None:
    keys = {
        cache_key(1, np.zeros(2), b""),
        cache_key(2, np.zeros(2), b""),
        cache_key(1, np.ones(2), b""),
        cache_key(1, np.zeros(2), b"x"),
        cache_key(1, np.zeros(1), np.zeros(1), b""),
    }
    assert len(keys) == 5
    assert cache_key(np.zeros(2)) == cache_key(bytes(16)) == hashlib.sha256(b"16;" + bytes(16)).hexdigest()


def test_a_changed_or_added_file_changes_the_state(tmp_path: Path) -> None:
    assert file_state(3) == 3 and file_state(tmp_path / "none") == str(tmp_path / "none")
    (tmp_path / "a.obj").write_text("v 0 0 0")
    states = [folder_state(tmp_path, "*.obj")]
    os.utime(tmp_path / "a.obj", (1, 1))
    states.append(folder_state(tmp_path, "*.obj"))
    (tmp_path / "a.obj").write_text("v 0 0 0 ")
    states.append(folder_state(tmp_path, "*.obj"))
    (tmp_path / "b.obj").write_text("")
    states.append(folder_state(tmp_path, "*.obj"))
    assert len({repr(state) for state in states}) == 4 and states[-1][0] == file_state(tmp_path / "a.obj")


def test_the_state_of_the_program_has_every_module_of_a_package() -> None:
    assert "conf/face/fapu.py" in repr(source_state("face")).replace(os.sep, "/")
    assert "fapu" not in repr(source_state("render"))
