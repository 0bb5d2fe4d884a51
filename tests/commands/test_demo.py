from pathlib import Path

import pytest

from conf.commands.demo import demo
from conf.errors import ConfError

pytestmark = pytest.mark.slow


def test_the_message_of_a_failed_sender_is_reported(gl: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("conf.sender.tracking.model_files.fetch_demo_clip", lambda: Path("nosuch.avi"))
    with pytest.raises(ConfError, match=r"no frame was received: conf: there is no file nosuch\.avi"):
        demo(seconds=30.0, headless=True)
