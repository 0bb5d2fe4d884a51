"""`conf settings`: what it prints, sets and refuses."""

import json
from pathlib import Path

import pytest

from conf.cli import main
from conf.commands.settings import DESCRIPTIONS
from conf.settings import NAMES, PATH_VARIABLE, Settings, load_settings


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "settings.toml"
    monkeypatch.setenv(PATH_VARIABLE, str(path))
    return path


def run(*arguments: str) -> object:
    with pytest.raises(SystemExit) as exit_:
        main(["settings", *arguments])
    return exit_.value.code


def test_settings_are_set_and_printed(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("name=Anna Lee", "portrait=yes", "kbps=9.6") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{path}:" and len(lines) == 1 + len(NAMES)
    rows = [line.split("  ") for line in lines]
    cells = {row[1]: [cell.strip() for cell in row[2:] if cell] for row in rows[1:]}
    assert cells["name"] == ["Anna Lee", "your name, which others see"]
    assert cells["portrait"][0] == "true" and cells["kbps"][0] == "9.6"
    assert cells["speaker"][0] == "not set: the system's"
    assert load_settings(path) == Settings(name="Anna Lee", portrait=True, kbps=9.6)
    assert run("name=") == 0
    assert load_settings(path).name is None


def test_json_has_every_setting(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--json", "kbps=16", "face=/a.obj") == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["path"] == str(path)
    assert printed["settings"] == dict.fromkeys(NAMES) | {"kbps": 16.0, "face": "/a.obj"}


def test_every_setting_is_described() -> None:
    assert set(DESCRIPTIONS) == set(NAMES)


def test_a_wrong_assignment_is_wrong_usage(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("voice=mp3") == 2
    assert "voice: expected one of auto, opus, codec2, off" in capsys.readouterr().err
    assert not path.exists()


def test_a_broken_file_is_an_error_and_kept_aside_by_a_change(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path.write_text("name = Anna\n")
    assert str(run()).startswith(f"conf: {path}, line 1: expected NAME = VALUE")
    assert path.read_text() == "name = Anna\n"
    assert run("name=Anna") == 0
    kept = path.with_name("settings.broken.toml")
    assert f"the former file could not be read and is kept as {kept}" in capsys.readouterr().out
    assert kept.read_text() == "name = Anna\n" and load_settings(path).name == "Anna"


@pytest.mark.slow
def test_a_call_with_a_broken_file_says_so_and_goes_on(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path.write_text("kpbs = 3\n")
    with pytest.raises(SystemExit) as exit_:
        main(["send", "127.0.0.1:9", "--code", "amber-canoe-tiger-7", "--file", "nosuch.avi"])
    assert "there is no file nosuch.avi" in str(exit_.value.code)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"conf: the settings are ignored: {path}, line 1: there is no setting 'kpbs', only name, ")
    assert path.read_text() == "kpbs = 3\n"
