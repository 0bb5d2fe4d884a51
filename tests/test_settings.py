"""Settings: what is read and written, what every error says, and that no file of the user is lost."""

import tomllib
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ConfError, FileFormatError
from conf.protocol.participant import state
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.settings import (
    MAX_FILE_BYTES,
    MAX_KBPS,
    MAX_NAME_BYTES,
    MIN_KBPS,
    NAMES,
    PATH_VARIABLE,
    VOICE_CHOICES,
    Settings,
    change_settings,
    edit_text,
    load_settings,
    parse_assignment,
    parse_settings,
    settings_path,
)

printable = st.text(st.characters(exclude_categories=("C", "Zl", "Zp", "Zs")), min_size=1, max_size=MAX_NAME_BYTES)
names = printable.filter(lambda name: len(name.encode()) <= MAX_NAME_BYTES)
some_settings = st.builds(
    Settings,
    name=st.none() | names,
    camera=st.none() | printable | st.integers(0, 99).map(str),
    microphone=st.none() | printable,
    speaker=st.none() | printable,
    portrait=st.none() | st.booleans(),
    kbps=st.none() | st.floats(MIN_KBPS, MAX_KBPS),
    voice=st.none() | st.sampled_from(VOICE_CHOICES),
    face=st.none() | printable.map(lambda name: Path("/") / name.strip("/.~")),
)
# What people write into such a file around the assignments.
line = st.sampled_from(["", "# a comment", "  # name = 1", "#kbps = 3 \r", "\t"])


@pytest.mark.slow
@given(some_settings)
def test_what_is_written_is_read_again(settings: Settings) -> None:
    text = edit_text("", Settings(), settings)
    tomllib.loads(text)
    assert parse_settings(text) == settings


@pytest.mark.slow
@given(some_settings, some_settings, st.lists(line), st.booleans())
def test_a_change_keeps_the_other_lines(before: Settings, after: Settings, lines: list[str], newline: bool) -> None:
    text = edit_text("\n".join(["# mine", *lines]) + "\n" * newline, Settings(), before)
    edited = edit_text(text, before, after)
    assert parse_settings(edited) == after
    kept = [line for line in edited.splitlines() if not line.startswith(NAMES)]
    assert [line for line in kept if line] == [line for line in ("# mine", *"\n".join(lines).splitlines()) if line]


def test_a_text_over_several_lines_is_written_anew() -> None:
    text = 'name = """\nAnna"""\nkbps = 3\n'
    edited = edit_text(text, parse_settings(text), Settings(name="Bea", kbps=3.0))
    assert parse_settings(edited) == Settings(name="Bea", kbps=3.0)


@given(st.text() | st.sampled_from(NAMES).flatmap(lambda name: st.text().map(lambda value: f"{name} = {value}")))
def test_any_text_is_settings_or_one_error(text: str) -> None:
    try:
        settings = parse_settings(text, "s.toml")
    except FileFormatError as error:
        assert str(error).startswith("s.toml") and str(error).endswith("; correct it, or delete the file")
    else:
        assert parse_settings(edit_text(text, settings, replace(settings, kbps=2.5))).kbps == 2.5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kbps = 3\nname", "s.toml, line 2: expected NAME = VALUE with texts in quotes, as in TOML"),
        ("name = Anna", "s.toml, line 1: expected NAME = VALUE with texts in quotes, as in TOML"),
        ("\nkpbs = 3", "s.toml, line 2: there is no setting 'kpbs', only name, camera, "),
        ("[name]\na = 1", "s.toml, line 1: name: expected a text of one line"),
        ('name = "a\\nb"', "s.toml, line 1: name: expected a text of one line"),
        ('name = " "', "s.toml, line 1: name: expected a text of one line"),
        (f'name = "{"a" * 33}"', "s.toml, line 1: name: expected at most 32 letters, fewer with accents"),
        (f'name = "{"ä" * 17}"', "s.toml, line 1: name: expected at most 32 letters, fewer with accents"),
        ("camera = -1", "s.toml, line 1: camera: expected a text of one line"),
        ("camera = true", "s.toml, line 1: camera: expected a text of one line"),
        ("# portrait = 1\nportrait = 1", "s.toml, line 2: portrait: expected true or false"),
        ("kbps = 0.9", "s.toml, line 1: kbps: expected a number of kbit/s, 1 or more"),
        ("kbps = nan", "s.toml, line 1: kbps: expected a number of kbit/s, 1 or more"),
        ("kbps = true", "s.toml, line 1: kbps: expected a number of kbit/s, 1 or more"),
        ("voice = []", "s.toml, line 1: voice: expected one of auto, opus, codec2, off"),
        ('face = "a.obj"', "s.toml, line 1: face: expected the full path of a file"),
    ],
)
def test_an_error_names_the_line_and_what_was_expected(text: str, message: str) -> None:
    with pytest.raises(FileFormatError) as error:
        parse_settings(text, "s.toml")
    assert str(error.value).startswith(message) and str(error.value).endswith("; correct it, or delete the file")


def test_numbers_of_devices_may_be_written_without_quotes() -> None:
    assert parse_settings("camera = 1\nspeaker = 0\nkbps = 16") == Settings(camera="1", speaker="0", kbps=16.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("name = Anna Höß ", ("name", "Anna Höß")),
        ("name=", ("name", None)),
        ("camera=1", ("camera", "1")),
        ("portrait=Yes", ("portrait", True)),
        ("portrait=off", ("portrait", False)),
        ("kbps=2.4", ("kbps", 2.4)),
        ("face=a=b.obj", ("face", Path("a=b.obj").absolute())),
    ],
)
def test_an_assignment_is_typed_without_quotes(text: str, expected: tuple[str, object]) -> None:
    assert parse_assignment(text) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name", "'name' is not NAME=VALUE"),
        ("nam=", "there is no setting 'nam'"),
        ("portrait=perhaps", "portrait: expected true or false"),
        ("kbps=fast", "kbps: expected a number of kbit/s, 1 or more"),
    ],
)
def test_a_wrong_assignment_says_what_was_expected(text: str, message: str) -> None:
    with pytest.raises(ValueError) as error:
        parse_assignment(text)
    assert str(error.value).startswith(message)


def test_a_missing_file_is_the_defaults(tmp_path: Path) -> None:
    assert load_settings(tmp_path / "no" / "settings.toml") == Settings()
    assert set(asdict(Settings()).values()) == {None}


def test_changes_keep_what_others_wrote_meanwhile(tmp_path: Path) -> None:
    path = tmp_path / "new folder" / "settings.toml"
    assert change_settings(path, {"name": "Anna"}) == (Settings(name="Anna"), None)
    path.write_text(f"\ufeff{path.read_text()}# mine\nkbps = 3 # slow\n", encoding="utf-8")
    assert change_settings(path, {"camera": "1"}) == (Settings(name="Anna", camera="1", kbps=3.0), None)
    assert path.read_text().splitlines()[1:] == ['name = "Anna"', "# mine", "kbps = 3 # slow", 'camera = "1"']
    change_settings(path, {"name": None, "kbps": None})
    assert load_settings(path) == Settings(camera="1") and list(path.parent.iterdir()) == [path]


def test_no_change_writes_nothing(tmp_path: Path) -> None:
    assert change_settings(tmp_path / "settings.toml", {"name": None}) == (Settings(), None)
    assert not list(tmp_path.iterdir())


def test_a_broken_file_is_kept_aside(tmp_path: Path) -> None:
    path = tmp_path / "settings.toml"
    for number, broken in enumerate((b"name = [", b"\xff\xfe", b"#" * (MAX_FILE_BYTES + 1))):
        path.write_bytes(broken)
        settings, kept = change_settings(path, {"kbps": 6.0})
        assert settings == Settings(kbps=6.0) == load_settings(path)
        name = "settings.broken.toml" if number == 0 else f"settings.broken-{number + 1}.toml"
        assert kept == tmp_path / name and kept.read_bytes() == broken


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"\xff", "expected text in UTF-8"), (b"#" * (MAX_FILE_BYTES + 1), "expected at most 64 KB")],
)
def test_a_file_that_is_no_text_is_an_error(content: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "settings.toml"
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match=message):
        load_settings(path)


def test_a_folder_in_its_place_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="cannot be read"):
        load_settings(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(ConfError, match=r"file.settings\.toml"):
        change_settings(tmp_path / "file" / "settings.toml", {"kbps": 3.0})


def test_the_path_is_that_of_the_system_or_of_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(PATH_VARIABLE, str(tmp_path / "a.toml"))
    assert settings_path() == tmp_path / "a.toml"
    monkeypatch.delenv(PATH_VARIABLE)
    assert settings_path().parts[-2:] == ("conf", "settings.toml")


def test_a_name_is_as_long_as_in_a_call() -> None:
    assert MAX_NAME_BYTES == state.MAX_NAME_BYTES
    assert parse_settings(f'name = "{"ä" * 16}"').name == "ä" * 16


def test_the_voices_are_those_of_the_protocol() -> None:
    assert set(VOICE_CHOICES) == set(VoiceMode)
