from pathlib import Path

import pytest

from conf.commands.demo import demo
from conf.errors import ConfError


def test_a_sender_that_fails_is_heard(gl: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("conf.commands.demo.fetch_demo_clip", lambda: Path("nosuch.avi"))
    with pytest.raises(ConfError, match=r"no frame came through: conf: there is no file nosuch\.avi"):
        demo(seconds=30.0, headless=True)
