"""The user's settings: defaults of options, kept in a TOML file that a person can edit.

Only values are read and written here; which option of which command has a setting as its default is decided in
`commands/support/option_defaults.py`. Nothing secret is kept: a pairing code is never a setting.
"""

import json
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from conf.atomic_write import atomic_write, report_write_errors
from conf.errors import FileFormatError

PATH_VARIABLE = "CONF_SETTINGS"
VOICE_CHOICES = ("auto", "opus", "codec2", "off")
MAX_NAME_BYTES = 32  # UTF-8, as in a call
MAX_FILE_BYTES = 1 << 16
MIN_KBPS, MAX_KBPS = 1, 1e6  # below it reports and headers take all

_HEADER = "# Settings of conf: defaults of its options. `conf settings` shows them.\n"
_BOOLEANS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
_ADVICE = "correct it, or delete the file"


@dataclass(frozen=True)
class Settings:
    """Defaults of options; None where the command's own default holds.

    name : what others call this participant
    camera : number or device; microphone, speaker : number or name
    portrait : whether images of the person may be sent
    kbps : highest rate, kbit/s; voice : one of VOICE_CHOICES
    face : a mesh file, absolute; head : name of the head that this participant is drawn with
    relay : HOST or HOST:PORT of a relay
    """

    name: str | None = None
    camera: str | None = None
    microphone: str | None = None
    speaker: str | None = None
    portrait: bool | None = None
    kbps: float | None = None
    voice: str | None = None
    face: Path | None = None
    head: str | None = None
    relay: str | None = None


NAMES = tuple(field.name for field in fields(Settings))


def _line_of_text(value: object) -> str:
    if not isinstance(value, str) or not value.strip() or any(not letter.isprintable() for letter in value):
        raise ValueError("expected a text of one line")
    return value.strip()


def _name(value: object) -> str:
    name = _line_of_text(value)
    if len(name.encode()) > MAX_NAME_BYTES:
        raise ValueError(f"expected at most {MAX_NAME_BYTES} letters, fewer with accents or of other scripts")
    return name


def _device(value: object) -> str:
    return str(value) if type(value) is int and value >= 0 else _line_of_text(value)


def _boolean(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("expected true or false")
    return value


def _kbps(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not MIN_KBPS <= value <= MAX_KBPS:
        raise ValueError(f"expected a number of kbit/s, {MIN_KBPS} or more")
    return float(value)


def _voice(value: object) -> str:
    if value not in VOICE_CHOICES:
        raise ValueError(f"expected one of {', '.join(VOICE_CHOICES)}")
    return str(value)


def _path(value: object) -> Path:
    path = Path(_line_of_text(value)).expanduser()
    if not path.is_absolute():
        raise ValueError("expected the full path of a file")
    return path


def _head(value: object) -> str:
    return _line_of_text(value).lower()


# Each returns the value of a field from the value in the file, or raises ValueError.
_READERS: dict[str, Callable[[object], object]] = {
    "name": _name, "camera": _device, "microphone": _device, "speaker": _device, "portrait": _boolean, "kbps": _kbps,
    "voice": _voice, "face": _path, "head": _head, "relay": _line_of_text,
}  # fmt: skip


def settings_path() -> Path:
    """Return the path of the settings file: CONF_SETTINGS, else in the folder where the system keeps settings."""
    if path := os.environ.get(PATH_VARIABLE):
        return Path(path)
    from platformdirs import user_config_path  # here: only some commands need it, and `conf --help` must be fast

    return user_config_path("conf", appauthor=False) / "settings.toml"


def load_settings(path: Path, /) -> Settings:
    """Return the settings of a file; the defaults if there is none. Raises FileFormatError with what to do."""
    return parse_settings(_read(path), path)


def parse_settings(text: str, path: object = "settings", /) -> Settings:
    """Return the settings of a TOML text.

    path : named in errors
    Raises FileFormatError with the line if it is not TOML, has an unknown name or a value of another kind.
    """
    import tomllib

    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        line = re.search(r"at line (\d+)", str(error))  # otherwise "at end of document"
        expected = f"expected NAME = VALUE with texts in quotes, as in TOML; {_ADVICE}"
        raise FileFormatError(path, int(line[1]) if line else len(text.splitlines()), expected) from error
    read = {}
    for name, value in values.items():
        try:
            read[name] = read_setting(name, value)
        except ValueError as error:
            raise FileFormatError(path, _line_number(text, name), f"{error}; {_ADVICE}") from error
    return replace(Settings(), **read)  # type: ignore[arg-type]


def read_setting(name: str, value: object, /) -> object:
    """Return the value of a setting from its value in TOML. Raises ValueError that names the setting."""
    if name not in _READERS:
        raise ValueError(f"there is no setting {name!r}, only {', '.join(NAMES)}")
    try:
        return _READERS[name](value)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def parse_assignment(text: str, /) -> tuple[str, object]:
    """Return name and value of NAME=VALUE as a user types it; of NAME= the value None, which unsets it.

    Raises ValueError that names the setting and what was expected.
    """
    name, separator, value = (part.strip() for part in text.partition("="))
    if not separator:
        raise ValueError(f"{text!r} is not NAME=VALUE")
    if not value and name in NAMES:
        return name, None
    if name == "face":
        return name, read_setting(name, str(Path(value).expanduser().absolute()))
    typed: object = value
    if name == "portrait":
        typed = _BOOLEANS.get(value.lower(), value)
    elif name == "kbps":
        try:
            typed = float(value)
        except ValueError:
            typed = value
    return name, read_setting(name, typed)


def change_settings(path: Path, changes: Mapping[str, object], /) -> tuple[Settings, Path | None]:
    """Change some settings of a file; the others, and its comments, stay.

    changes : name -> value as Settings has it, None to unset it
    Returns the settings, and where the file was moved if it could not be read; None if it could.
    Raises ConfError if the file cannot be written.
    """
    kept_aside = None
    try:
        text = _read(path)
        settings = parse_settings(text, path)
    except FileFormatError:
        text, settings = "", Settings()
        with report_write_errors(path):
            kept_aside = path.rename(_free_path(path.with_name(f"{path.stem}.broken{path.suffix}")))
    changed = replace(settings, **changes)  # type: ignore[arg-type]
    if changed == settings and kept_aside is None:
        return settings, None
    with report_write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as partial:
            partial.write_text(edit_text(text, settings, changed), encoding="utf-8")
    return changed, kept_aside


def edit_text(text: str, settings: Settings, changed: Settings, /) -> str:
    """Return a TOML text with the settings `changed`; text is that of `settings`, and its other lines stay."""
    before, after = toml_values(settings), toml_values(changed)
    lines = text.splitlines(keepends=True) or [_HEADER]
    for name in NAMES:
        if before[name] == after[name]:
            continue
        new = "" if after[name] is None else f"{name} = {after[name]}\n"
        number = _line_number(text, name)
        if number is not None:
            lines[number - 1] = new
        elif new:
            if not lines[-1].endswith("\n"):
                lines[-1] += "\n"
            lines.append(new)
    edited = "".join(lines)
    try:
        if parse_settings(edited) == changed:
            return edited
    except FileFormatError:
        pass  # written in a way that line by line cannot change, such as a text over several lines
    return _HEADER + "".join(f"{name} = {value}\n" for name, value in after.items() if value is not None)


def toml_values(settings: Settings, /) -> dict[str, str | None]:
    """Return each setting as TOML writes it; None if it is not set."""
    return {name: None if value is None else _toml_value(value) for name, value in asdict(settings).items()}


def _toml_value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() else repr(value)
    return json.dumps(str(value), ensure_ascii=False)  # printable text: JSON's strings are TOML's


def _line_number(text: str, name: str) -> int | None:
    """Return the number, from 1, of the line that assigns a setting."""
    pattern = re.compile(rf"[ \t]*[\"']?{re.escape(name)}[\"']?[ \t]*[=.]|[ \t]*\[+[ \t]*{re.escape(name)}[ \t]*\]")
    return next((number for number, line in enumerate(text.splitlines(), 1) if pattern.match(line)), None)


def _read(path: Path) -> str:
    """Return the text of a file, empty if there is none. Raises FileFormatError."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise FileFormatError(path, None, f"cannot be read ({error.strerror}); {_ADVICE}") from error
    if len(content) > MAX_FILE_BYTES:
        raise FileFormatError(path, None, f"expected at most {MAX_FILE_BYTES >> 10} KB; {_ADVICE}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(path, None, f"expected text in UTF-8; {_ADVICE}") from error


def _free_path(path: Path) -> Path:
    """Return the path, with a number if it exists."""
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return free
