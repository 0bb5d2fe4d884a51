import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from conf import cli
from conf.cli import main
from conf.commands.support.interruption import until_interrupted
from conf.errors import ConfError

CODE = ("--code", "amber canoe tiger 7")


@pytest.fixture(autouse=True)
def signal_handlers() -> Iterator[None]:
    """Restore the signal handlers that main sets."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = dict(os.environ)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        environment.pop(name, None)
    command = [sys.executable, "-m", "conf", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=environment, timeout=120, check=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["send", "127.0.0.1", *CODE, "--file", "nosuch.avi"], "there is no file nosuch.avi: check the path"),
        (["send", "127.0.0.1", *CODE, "--camera", "99"], "there is no camera 99: plug one in"),
        (["send", "no.such.host.invalid", *CODE, "--file", "x"], "no address for 'no.such.host.invalid'"),
        (["send", "127.0.0.1", "--file", "x"], "give the one the receiver shows with --code"),
        (["receive", "--listen", "203.0.113.7:5005", "--headless", "o.avi"], "cannot listen on 203.0.113.7:5005"),
        (["receive", "--listen", "127.0.0.1:0", "--seconds", "1"], "no window can be opened"),
        (["receive", "--listen", "127.0.0.1:0", "--face", "nosuch.obj", "--headless", "o.avi"], "nosuch.obj"),
        (["receive", "--listen", "127.0.0.1:0", "--headless", "o.mov", "--seconds", "1"], "must end in .mp4 or .avi"),
        (["extract", "nosuch.avi", "-o", "o.dpc"], "there is no file nosuch.avi"),
        (["measure", "nosuch.avi"], "there is no file nosuch.avi"),
    ],
)
def test_an_error_is_one_line_and_exit_status_1(arguments: list[str], message: str, tmp_path: Path) -> None:
    result = run(*arguments, cwd=tmp_path)
    assert result.returncode == 1, result.stderr
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("conf: ") and message in last
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["fly"],
        ["send"],
        ["receive", "--listen", "127.0.0.1:99999"],
        ["demo", "--seconds", "-1"],
        ["send", "host:port"],
        ["send", "h", "--code", "x"],
    ],
)
def test_wrong_usage_is_exit_status_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(arguments)
    assert exit_.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("conf") and ": error: " in line and line.endswith(" --help)")


@pytest.mark.slow
def test_without_a_command_and_a_display_the_help_is_printed(tmp_path: Path) -> None:
    result = run(cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "") and result.stdout.startswith("usage: conf")


def test_without_a_command_the_start_window_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[bool] = []
    monkeypatch.setattr(cli, "has_display", lambda: True)
    monkeypatch.setattr(cli, "open_start_window", lambda: opened.append(True))
    with pytest.raises(SystemExit) as exit_:
        main([])
    assert exit_.value.code == 0 and opened == [True]


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_and_version_import_no_heavy_module(option: str, tmp_path: Path) -> None:
    script = f"import sys; from conf import cli\ntry: cli.main(['{option}'])\nexcept SystemExit: print(*sys.modules)"
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert not {"numpy", "cv2", "scipy", "moderngl", "rich"} & set(result.stdout.split())


@pytest.mark.slow
def test_doctor_reports_checks_and_remedies(tmp_path: Path) -> None:
    result = run("doctor", "--camera", "99", "--listen", "127.0.0.1:0", "--json", cwd=tmp_path)
    findings = {finding["name"]: finding for finding in json.loads(result.stdout)["findings"]}
    assert result.returncode == 0
    assert not findings["camera"]["works"] and "plug one in" in findings["camera"]["detail"]
    assert not findings["window"]["works"] and "--headless" in findings["window"]["detail"]
    assert findings["port"]["works"]


@pytest.mark.slow
def test_measure_reports_every_stage(carphone_clip: Path, tmp_path: Path) -> None:
    result = run("measure", str(carphone_clip), "--json", "--plot", "plot.png", cwd=tmp_path)
    stages = {stage["name"]: stage for stage in json.loads(result.stdout)["stages"]}
    assert stages["raw pixels 193x144"]["bytes_per_frame"] == 193 * 144 * 3
    wire = stages["with UDP/IP headers"]
    assert wire["ratio"] == pytest.approx(193 * 144 * 3 / wire["bytes_per_frame"])
    costs = [
        stage["bytes_per_frame"] for name, stage in stages.items() if "JPEG" not in name and "landmarks" not in name
    ]
    assert costs[0] > 1000 * costs[-1]
    assert (tmp_path / "plot.png").stat().st_size > 3000


@pytest.mark.slow
def test_extract_writes_a_valid_dpc_file(carphone_clip: Path, tmp_path: Path) -> None:
    from conf.face.formats.dpc import read_dpc

    result = run("extract", str(carphone_clip), "-o", "motion.dpc", "--json", cwd=tmp_path)
    figures = json.loads(result.stdout)
    motion = read_dpc(tmp_path / "motion.dpc")
    assert figures["frames"] == figures["frames_tracked"] == len(motion.displacements) == 120
    assert motion.units == "fapu" and motion.fps == pytest.approx(30, abs=0.1)
    assert motion.poses is not None and motion.displacements[:, 2, 1].min() < -200  # the mouth opens


@pytest.mark.slow
def test_demo_without_a_display_writes_clip_image_and_figures(tmp_path: Path) -> None:
    result = run("demo", "--seconds", "6", "--json", cwd=tmp_path)
    figures = json.loads(result.stdout)
    assert figures.keys() >= {"frames_received", "frames_lost", "frames_late", "fps", "wire_bytes_per_frame"}
    assert figures.keys() >= {"wire_kbps", "raw_bytes_per_frame", "raw_kbps", "ratio"}
    assert figures["frames_received"] > 10  # a still face sends few
    assert (tmp_path / "conf-demo.mp4").stat().st_size > 5_000
    assert (tmp_path / "conf-demo.jpg").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "moment",
    [
        "import conf.__main__; {interrupt}",
        "import conf.cli; from conf.__main__ import main; conf.cli.build_parser = lambda: {interrupt}; main()",
        "import conf.cli; from conf.__main__ import main; conf.cli.main = lambda: {interrupt}; main()",
        "import json, conf.cli; from conf.__main__ import main; conf.cli.main = lambda: None; main(); {interrupt}",
    ],
    ids=["while modules are imported", "while arguments are parsed", "a second one", "after the command"],
)
def test_ctrl_c_prints_nothing_at_any_moment(moment: str) -> None:
    code = moment.format(interrupt="__import__('signal').raise_signal(2)") + "; print('not reached')"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (result.stdout, result.stderr) == ("", "")
    assert result.returncode in (130, -signal.SIGINT)  # a shell reports both as 130


def test_the_handler_of_ctrl_c_is_set_before_anything_is_imported() -> None:
    """What Python has not loaded by itself takes time in which Ctrl-C prints its traceback."""
    code = "import os, sys; loaded = {*sys.modules}; import conf.__main__; print(*sorted({*sys.modules} - loaded))"
    environment = os.environ | {"PYTHONPATH": str(Path(cli.__file__).parents[1])}
    result = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True, env=environment)
    assert result.stdout.split() == ["conf", "conf.__main__"]


def interrupted(*swallowed_by: type[BaseException]) -> None:
    """Interrupt the program; the exceptions named are swallowed, as a library may do."""
    try:
        signal.raise_signal(signal.SIGINT)
    except swallowed_by:
        pass


def convert() -> None:
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt as error:
        raise ImportError("initialisation failed") from error


def swallow_then_call() -> None:
    interrupted(KeyboardInterrupt)
    with until_interrupted():
        raise AssertionError("the call has begun")


def swallow_then_report() -> None:
    with cli._Terminal(json=True).status_line() as show:
        interrupted(KeyboardInterrupt)
        show("tracking")


def write_a_file() -> None:
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt as error:
        error.add_note("/tmp/a.mp4 is as it was before")
        raise


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (interrupted, ""),
        (convert, ""),
        (swallow_then_call, ""),
        (swallow_then_report, ""),
        (write_a_file, "conf: interrupted: /tmp/a.mp4 is as it was before\n"),
    ],
)
def test_an_interrupted_command_exits_with_130_and_names_what_it_wrote(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], task: Callable[[], None], message: str
) -> None:
    monkeypatch.setattr("conf.commands.models.run", lambda options, terminal: task())
    with pytest.raises(SystemExit) as exit_:
        main(["models", "fetch"])
    assert exit_.value.code == 130
    assert capsys.readouterr() == ("", message)


def test_the_notes_of_an_error_are_part_of_its_line(monkeypatch: pytest.MonkeyPatch) -> None:
    error = ConfError("the disk is full")
    error.add_note("b.mp4 is as it was before")

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("conf.commands.models.run", fail)
    with pytest.raises(SystemExit) as exit_:
        main(["models", "fetch"])
    assert exit_.value.code == "conf: the disk is full; b.mp4 is as it was before"
