from pathlib import Path

import pytest

from conf.commands.animate import animate
from conf.errors import ConfError, FileFormatError


def test_what_is_wrong_is_said_before_a_window_opens(tmp_path: Path) -> None:
    with pytest.raises(ConfError, match="there is no emotion 'glee': choose one of joy"):
        animate(emotion="glee")
    with pytest.raises(FileFormatError, match=r"nowhere\.obj"):
        animate(tmp_path / "nowhere.obj")
