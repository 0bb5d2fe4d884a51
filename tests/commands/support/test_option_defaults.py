"""Settings are defaults of options: the command line wins, and a file is read only where an option needs it."""

from pathlib import Path

import pytest

from conf.cli import build_parser
from conf.commands.support.option_defaults import RELAY_VARIABLE, apply_settings
from conf.errors import ConfError
from conf.settings import Settings

SETTINGS = Settings("Anna", "2", "Headset", "HDMI", True, 9.6, "codec2", Path("/tmp/a.obj"))


def parse(line: str, settings: Settings = SETTINGS) -> dict[str, object]:
    options = build_parser().parse_args(line.split())
    apply_settings(options, lambda: settings)
    return vars(options)


def test_settings_are_used_where_an_option_is_not_given() -> None:
    sent = {"camera": "2", "microphone": "Headset", "portrait": True, "kbps": 9.6, "voice": "codec2"}
    assert parse("send h").items() >= sent.items()
    assert parse("receive").items() >= {"face": Path("/tmp/a.obj"), "speaker": "HDMI"}.items()
    assert parse("doctor")["camera"] == "2"
    both = {"name": "Anna", "speaker": "HDMI", "face": Path("/tmp/a.obj")}
    assert parse("call h").items() >= (sent | both).items()
    assert parse("call h --name Bea --file c.mp4").items() >= {"name": "Bea", "microphone": None}.items()


def test_without_settings_the_defaults_of_the_options_hold() -> None:
    defaults = {"camera": "0", "microphone": None, "portrait": False, "kbps": None, "voice": "auto"}
    assert parse("send h", Settings()).items() >= defaults.items()
    assert parse("receive", Settings()).items() >= {"face": None, "speaker": None}.items()


@pytest.mark.parametrize(
    ("arguments", "name", "value"),
    [
        ("--camera 0", "camera", "0"),  # the option's own default, but given
        ("--microphone 1", "microphone", "1"),
        ("--no-portrait", "portrait", False),
        ("--portrait", "portrait", True),
        ("--kbps 1000", "kbps", 1000.0),
        ("--voice auto", "voice", "auto"),
    ],
)
def test_the_command_line_wins(arguments: str, name: str, value: object) -> None:
    assert parse(f"send h {arguments}")[name] == value


@pytest.mark.parametrize("source", ["--file c.mp4", "--dpc m.dpc", "--sound s.wav"])
def test_a_microphone_of_the_settings_does_not_replace_the_sound_of_a_file(source: str) -> None:
    assert parse(f"send h {source}")["microphone"] is None


@pytest.mark.parametrize("line", ["animate", "export --emotion joy -o a.jpg", "fit a.obj", "settings", "models path"])
def test_other_commands_do_not_read_the_settings(line: str) -> None:
    def load() -> Settings:
        raise AssertionError("the settings were read")

    apply_settings(build_parser().parse_args(line.split()), load)


def test_the_relay_is_named_by_option_variable_or_setting_in_this_order(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = Settings(relay="set.example:99")
    monkeypatch.delenv(RELAY_VARIABLE, raising=False)
    assert parse("call", Settings())["relay"] is None
    assert parse("call", settings)["relay"] == ("set.example", 99)
    monkeypatch.setenv(RELAY_VARIABLE, "env.example")
    assert parse("call", settings)["relay"] == ("env.example", 7447)
    assert parse("call --relay a.example", settings)["relay"] == ("a.example", 7447)
    monkeypatch.setenv(RELAY_VARIABLE, "a]:b")
    with pytest.raises(ConfError, match="relay: a]:b is not HOST:PORT"):
        parse("call", settings)
