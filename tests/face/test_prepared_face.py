import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.default_head import DEFAULT_HEAD
from conf.face.loading import load_face
from conf.face.prepared_face import prepared_face


def assert_same(found: Any, expected: Any, where: str = "face") -> None:
    """Compare two objects to their last array."""
    assert type(found) is type(expected), where
    if is_dataclass(expected):
        for field in fields(expected):
            assert_same(getattr(found, field.name), getattr(expected, field.name), f"{where}.{field.name}")
    elif isinstance(expected, np.ndarray):
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected, where)
    elif isinstance(expected, dict):
        assert list(found) == list(expected)
        for name in expected:
            assert_same(found[name], expected[name], f"{where}[{name}]")
    elif isinstance(expected, tuple):
        assert len(found) == len(expected)
        for number, (a, b) in enumerate(zip(found, expected, strict=True)):
            assert_same(a, b, f"{where}[{number}]")
    else:
        assert found == expected, where


@pytest.mark.slow
def test_the_default_head_from_the_cache_is_the_one_from_its_files(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    head = load_face()
    assert_same(prepared_face(), head)
    monkeypatch.setattr("conf.face.loading.load_face", None)  # a second call would raise
    assert_same(prepared_face(), head)
    assert_same(prepared_face(DEFAULT_HEAD), head)


@pytest.mark.slow
def test_a_cached_head_needs_no_scipy() -> None:
    prepared_face()
    check = "import sys; from conf.face.prepared_face import prepared_face as f; f(); sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-P", "-c", check], check=False).returncode == 0


def test_a_face_from_elsewhere_is_loaded(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="expected a mesh file"):
        prepared_face(tmp_path / "own.txt")
