import argparse
import shutil
import subprocess
from pathlib import Path

import pytest

from conf.cli import COMMANDS, build_parser
from tools.packaging.shell_files import COMPLETIONS, MANUAL, complete_paths, write_shell_files

BASH = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
function=$(complete -p conf | sed 's/.*-F \\([^ ]*\\).*/\\1/')
$function conf "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""
CASES = [
    ("rec", {"receive"}),
    ("send --prof", {"--profile"}),
    ("send host --profile ", {"auto", "live", "narrow", "rich"}),
    ("send host --file cl", {"clip.mp4"}),
    ("extract cl", {"clip.mp4"}),
    ("models ", {"fetch", "path"}),
    ("doctor --check w", {"window"}),
]
# zsh completes in its line editor only: here its script is checked for errors of syntax.
SYNTAX = {"zsh": ["zsh", "-n"], "fish": ["fish", "--no-execute"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shell")
    write_shell_files(folder)
    (folder / "clip.mp4").touch()
    return folder


def output(*command: str, cwd: Path) -> str:
    if not shutil.which(command[0]):
        pytest.skip(f"{command[0]} is not installed")
    result = subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)
    assert result.returncode == 0 and not result.stderr, result.stderr
    return result.stdout


def test_the_files_are_where_shells_look_for_them(tmp_path: Path) -> None:
    files = {f"{target}/{Path(path).name}" for target, paths in write_shell_files(tmp_path) for path in paths}
    assert files == {MANUAL, *COMPLETIONS.values()}
    assert all((tmp_path / name).stat().st_size > 1000 for name in files)


@pytest.mark.parametrize(("line", "expected"), CASES)
def test_bash_completes(folder: Path, line: str, expected: set[str]) -> None:
    words = ["conf", *line.split(" ")]
    printed = output("bash", "-c", BASH, "bash", COMPLETIONS["bash"], *words, cwd=folder)
    assert set(printed.split()) == expected


@pytest.mark.slow
@pytest.mark.parametrize(("line", "expected"), CASES)
def test_fish_completes(folder: Path, line: str, expected: set[str]) -> None:
    script = f"source {COMPLETIONS['fish']}; complete -C 'conf {line}'"
    printed = output("fish", "--no-config", "-c", script, cwd=folder)
    assert {entry.split("\t")[0] for entry in printed.splitlines()} == expected


@pytest.mark.parametrize("shell", SYNTAX)
def test_a_script_has_no_error_of_syntax(folder: Path, shell: str) -> None:
    output(*SYNTAX[shell], COMPLETIONS[shell], cwd=folder)
    text = (folder / COMPLETIONS[shell]).read_text()
    assert all(command in text for command in COMMANDS) and "portrait-kbps" in text


def test_the_manual_page_describes_every_command_and_option(folder: Path) -> None:
    text = (folder / MANUAL).read_text().replace("\\-", "-")
    assert text.startswith('.TH CONF "1"') and "CONF_CODE" in text and ".SH EXIT STATUS" in text
    (subparsers,) = [action for action in build_parser()._actions if isinstance(action, argparse._SubParsersAction)]
    for name, parser in subparsers.choices.items():
        assert f"conf {name}" in text
        assert all(option in text for action in parser._actions[1:] for option in action.option_strings)


@pytest.mark.slow
def test_man_shows_the_page_without_a_warning(folder: Path) -> None:
    printed = output("man", "--warnings", "--local-file", str(folder / MANUAL), cwd=folder)
    assert "conf - video conference" in printed and "--listen [HOST:]PORT" in printed


def test_arguments_that_are_paths_complete_to_files() -> None:
    parser = argparse.ArgumentParser()
    subparser = parser.add_subparsers().add_parser("show")
    clip, size = subparser.add_argument("clip", type=Path), subparser.add_argument("--size")
    complete_paths(parser)
    assert hasattr(clip, "complete") and not hasattr(size, "complete")
