"""Every command that README shows is run as it stands, with its placeholders filled in and its calls kept short."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from conf.face.default_head import DEFAULT_HEAD
from conf.output.wav_writer import write_wav

REPOSITORY = Path(__file__).parents[1]
README = (REPOSITORY / "README.md").read_text()
COMMANDS = [line.split("  #")[0].strip() for line in README.splitlines() if line.startswith(("    conf ", "    make "))]
CALLS = [line for line in COMMANDS if line.startswith("conf send ")]
TWO_WAY = [line for line in COMMANDS if line.startswith("conf call ")]
OTHERS = [line for line in COMMANDS if line.startswith("conf ") and line not in CALLS + TWO_WAY]
INLINE = re.findall(r"`((?:conf|make) [a-z]+[^`]*)`", README)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, carphone_clip: Path) -> Path:
    """A folder with the files that README's commands name."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copy(carphone_clip, folder / "clip.avi")
    for name in ("head.obj", "head.mtl", "skin.webp"):
        if DEFAULT_HEAD.with_name(name).is_file():
            shutil.copy(DEFAULT_HEAD.with_name(name), folder / name)
    (folder / "head.obj").rename(folder / "FACE.obj")
    write_wav(folder / "talk.wav", np.random.default_rng(1).integers(-3000, 3000, 16_000).astype(np.int16), rate=16_000)
    return folder


@pytest.fixture(scope="module")
def receiver(folder: Path) -> Iterator[tuple[str, str]]:
    """The address and the code of a running receiver: README's first command, on a free port, drawing off-screen."""
    (listen,) = [line for line in OTHERS if line.startswith("conf receive --listen")]
    command = arguments(listen.replace("5005", "127.0.0.1:0"))
    command += ["--headless", "call.avi", "--seconds", "120", "--json"]
    with subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True, env=environment()) as process:
        assert process.stderr
        found = re.search(r"listening on (\S+), code (\S+)", process.stderr.readline())
        assert found
        yield found[1], found[2]
        process.terminate()


def environment(**more: str) -> dict[str, str]:
    return os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(REPOSITORY)} | more


def arguments(line: str) -> list[str]:
    return [sys.executable, "-m", "conf", *shlex.split(line)[1:]]


def run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment(), timeout=180)
    assert done.returncode == 0, done.stderr


def test_both_ends_of_a_call_of_readme_are_held(folder: Path) -> None:
    """As they stand, but on a free port, with a clip as the camera, and without windows."""
    listen, called = (arguments(line) for line in TWO_WAY)
    more = ["--file", "clip.avi", "--loop", "--no-sound", "--headless"]
    listen = [*(word.replace("5005", "127.0.0.1:0") for word in listen), *more, "listening.avi", "--seconds", "120"]
    with subprocess.Popen(listen, cwd=folder, stdout=subprocess.PIPE, text=True, env=environment()) as process:
        assert process.stdout
        found = re.search(r"listening on (\S+), code (\S+)", process.stdout.readline())
        assert found
        words = [{"HOST": found[1], "CODE": found[2]}.get(word, word) for word in called]
        run([*words, *more, "calling.avi", "--seconds", "3"], folder)
        process.terminate()


def test_readme_shows_commands() -> None:
    assert len(CALLS) >= 4 and len(OTHERS) >= 5


@pytest.mark.parametrize("line", CALLS)
def test_a_call_of_readme_is_made(line: str, folder: Path, receiver: tuple[str, str]) -> None:
    address, code = receiver
    command = arguments(line.replace("HOST", address).replace("CODE", code))
    if not {"--file", "--dpc"} & set(command):
        command += ["--file", "clip.avi"]  # in place of a webcam
    if "--dpc" in command and not (folder / "motion.dpc").is_file():
        run(arguments("conf extract clip.avi -o motion.dpc"), folder)
    run([*command, "--seconds", "6"], folder)  # the receiver may still be loading its head


@pytest.mark.parametrize("line", [line for line in OTHERS if "animate" not in line and "--listen" not in line])
def test_a_command_of_readme_is_run(line: str, folder: Path) -> None:
    command = arguments(line)
    if "receive" in command:
        if not (folder / "FACE.ppc").is_file():
            shutil.copy(DEFAULT_HEAD.with_suffix(".ppc"), folder / "FACE.ppc")
        command += ["--listen", "127.0.0.1:0", "--headless", "face.avi", "--seconds", "1"]
    run(command, folder)
    for output in re.findall(r"-o (\S+)", line):
        assert (folder / output).stat().st_size > 0


def test_the_animator_opens_as_readme_says(folder: Path, display: str) -> None:
    (line,) = [line for line in OTHERS if line.startswith("conf animate")]
    with subprocess.Popen(arguments(line), cwd=folder, env=environment(DISPLAY=display)) as process:
        searched = 60.0
        while searched > 0 and process.poll() is None and not _has_window(display):
            time.sleep(0.25)
            searched -= 0.25
        assert process.poll() is None and _has_window(display)
        process.terminate()


def _has_window(display: str) -> bool:
    command = ["xdotool", "search", "--name", "conf"]
    return subprocess.run(command, capture_output=True, env=os.environ | {"DISPLAY": display}).returncode == 0


@pytest.mark.parametrize("line", [line for line in (*COMMANDS, *INLINE) if line.startswith("make ")])
def test_a_make_target_of_readme_exists(line: str) -> None:
    done = subprocess.run(["make", "-n", *line.split()[1:]], cwd=REPOSITORY, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("line", sorted({" ".join(line.split()[:2]) for line in INLINE if line.startswith("conf ")}))
def test_a_command_in_the_text_of_readme_exists(line: str) -> None:
    run([*arguments(line), "--help"], REPOSITORY)


@pytest.mark.parametrize("path", sorted(set(re.findall(r"\]\(([^)#:]+)\)|`((?:docs|tools|conf)/[\w/.]+)`", README))))
def test_a_file_that_readme_names_exists(path: tuple[str, str]) -> None:
    assert (REPOSITORY / (path[0] or path[1])).exists()
