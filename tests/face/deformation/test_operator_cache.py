import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from conf.face.deformation.operator_cache import cache_folder, cache_key, cached_operator
from conf.face.deformation.rbf import Operator

SHAPE = (5, 3)
OPERATOR = Operator(np.arange(15, dtype=np.float32).reshape(SHAPE), 0.1)


@pytest.fixture(autouse=True)
def _empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def builder() -> tuple[Callable[[], Operator], list[int]]:
    calls: list[int] = []

    def build() -> Operator:
        calls.append(1)
        return OPERATOR

    return build, calls


def test_a_cached_operator_is_not_built_again() -> None:
    build, calls = builder()
    for _ in range(3):
        operator = cached_operator("key", SHAPE, build)
        assert operator.matrix.tolist() == OPERATOR.matrix.tolist()
        assert operator.smoothing == 0.1
    assert len(calls) == 1


@pytest.mark.parametrize(
    "damage",
    [
        b"",
        b"\x93NUMPY\x01\x00",
        b"not an array",
        b"\x00" * 10_000_000,
        np.zeros(17, dtype=np.float64),
        np.zeros(16, dtype=np.float32),
        np.zeros((4, 4), dtype=np.float32),
        np.full(17, np.nan, dtype=np.float32),
        np.concatenate([np.array([np.nan]).view(np.float32), np.zeros(15, dtype=np.float32)]),
        np.array([{}] * 17, dtype=object),
        None,
    ],
    ids=["empty", "cut", "text", "large", "float64", "short", "shape", "nan", "nan lambda", "objects", "folder"],
)
def test_a_damaged_file_is_replaced(damage: bytes | np.ndarray | None) -> None:
    build, calls = builder()
    path = cache_folder() / "key.npy"
    path.parent.mkdir(parents=True)
    if damage is None:
        path.mkdir()
    elif isinstance(damage, bytes):
        path.write_bytes(damage)
    else:
        np.save(path, damage, allow_pickle=True)
    assert cached_operator("key", SHAPE, build).matrix.tolist() == OPERATOR.matrix.tolist()
    assert len(calls) == 1


class Touch:
    """An object whose pickle makes a file when it is read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


def test_a_pickle_in_the_cache_is_not_executed(tmp_path: Path) -> None:
    cache_folder().mkdir(parents=True)
    np.save(cache_folder() / "key.npy", np.array([Touch(tmp_path / "executed")], dtype=object), allow_pickle=True)
    assert cached_operator("key", SHAPE, lambda: OPERATOR) is OPERATOR
    assert not (tmp_path / "executed").exists()


def test_a_large_operator_is_cached_too() -> None:
    large = Operator(np.ones((2000, 3), dtype=np.float32), 0.25)
    cached_operator("key", (2000, 3), lambda: large)
    build, calls = builder()
    assert cached_operator("key", (2000, 3), build).smoothing == 0.25
    assert not calls


def test_the_folder_is_the_user_s(tmp_path: Path) -> None:
    assert cache_folder() == tmp_path / "conf" / "operators"


def test_an_unwritable_cache_is_ignored(tmp_path: Path) -> None:
    (tmp_path / "conf").write_text("a file where the folder should be")
    build, calls = builder()
    for _ in range(2):
        assert cached_operator("key", SHAPE, build) is OPERATOR
    assert len(calls) == 2


def test_only_the_newest_files_are_kept() -> None:
    for i in range(20):
        cached_operator(f"key{i}", SHAPE, lambda: OPERATOR)
    assert len(list(cache_folder().iterdir())) == 16


def test_the_oldest_file_is_removed_whatever_its_name() -> None:
    for i in range(16):
        cached_operator(f"key{99 - i}", SHAPE, lambda: OPERATOR)
        os.utime(cache_folder() / f"key{99 - i}.npy", (i, i))
    cached_operator("another", SHAPE, lambda: OPERATOR)
    assert {path.stem for path in cache_folder().iterdir()} == {"another", *(f"key{99 - i}" for i in range(1, 16))}


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
