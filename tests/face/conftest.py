"""The sheet face for every test of face/, and a cache of the tests' own."""

import pytest

from tests.support.sheet_face import face, shut_face

__all__ = ["face", "shut_face"]


@pytest.fixture(autouse=True)
def _own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the user's cache out of the tests."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
