from pathlib import Path

import pytest

from conf.commands.support.display import check_before_call, has_display
from conf.errors import ConfError, FileFormatError, GraphicsError


@pytest.mark.parametrize(
    ("platform", "variables", "expected"),
    [
        ("linux", {}, False),
        ("linux", {"DISPLAY": ":0"}, True),
        ("linux", {"WAYLAND_DISPLAY": "w"}, True),
        ("darwin", {}, True),
        ("win32", {}, True),
    ],
)
def test_a_display_is_detected_by_its_environment_variable(
    monkeypatch: pytest.MonkeyPatch, platform: str, variables: dict[str, str], expected: bool
) -> None:
    monkeypatch.setattr("conf.commands.support.display.sys.platform", platform)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert has_display() is expected


def test_what_cannot_be_shown_is_told_before_the_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"nope\.obj: expected a file; check the name"):
        check_before_call(tmp_path / "nope.obj", None)
    face = tmp_path / "face.obj"
    face.touch()
    with pytest.raises(FileFormatError, match=r"face\.ppc: expected a file; `conf fit .*face\.obj` makes it"):
        check_before_call(face, None)
    face.with_suffix(".ppc").touch()
    monkeypatch.setattr("conf.commands.support.display.has_display", lambda: False)
    check_before_call(face, tmp_path / "call.avi")
    with pytest.raises(GraphicsError, match="no window can be opened: there is no display"):
        check_before_call(face, None)


@pytest.mark.parametrize(
    ("name", "message"),
    [("call.mov", "must end in .mp4 or .avi"), ("none/call.mp4", "cannot be written"), ("call", "must end in")],
)
def test_a_clip_is_checked_before_the_call(tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(ConfError, match=message):
        check_before_call(None, tmp_path / name)
    check_before_call(None, tmp_path / "call.mp4")
    assert not list(tmp_path.iterdir())
