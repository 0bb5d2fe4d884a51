import json
import os
import re
import signal
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from conf.cli import build_parser, main
from conf.transport.zenoh_transport import RelayTransport
from tests.support.relay import LOOPBACK, exchange, free_port
from tests.support.simulated_sessions import seeded


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent to a process")
def test_a_relay_carries_a_call_and_ends_with_its_figures(tmp_path: Path) -> None:
    port = free_port()
    command = [sys.executable, "-m", "conf", "relay", "--listen", f"{LOOPBACK}:{port}", "--json"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path, env=dict(os.environ)) as process:
        assert process.stderr and process.stdout
        line = process.stderr.readline()
        assert line == f"relay on {LOOPBACK}:{port}, TCP and UDP; STUN on UDP ports {port + 1} and {port + 2}\n"
        with (
            RelayTransport.wait_at((LOOPBACK, port), "4711") as waiter,
            RelayTransport.call((LOOPBACK, port), "4711", seeded(1)) as caller,
        ):
            exchange(waiter, caller)
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=20)
        figures = json.loads(output)
        assert process.returncode == 0 and figures["seconds"] > 0
        assert "4711" not in line + output + errors


@pytest.mark.slow
def test_a_relay_imports_no_package_that_the_container_does_not_install() -> None:
    steps = (Path(__file__).parents[2] / "docs/deploy/Containerfile").read_text()
    (installed,) = re.findall(r"--constraint \S+ (.*?)\s*\\?$", steps, re.MULTILINE)
    program = (
        "import atexit, sys; before = set(sys.modules); from conf.cli import main\n"
        "atexit.register(lambda: print(*{name.partition('.')[0] for name in set(sys.modules) - before}))\n"
        f"main(['relay', '--listen', '{LOOPBACK}:{free_port()}', '--seconds', '0.1'])"
    )
    output = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    loaded = set(output.splitlines()[-1].split())
    distributions = {name for module, names in packages_distributions().items() if module in loaded for name in names}
    assert distributions == {"conf", *installed.split()}


def test_the_ports_of_a_relay() -> None:
    parser = build_parser()
    assert parser.parse_args(["relay"]).listen == ("", 7447)
    assert parser.parse_args(["relay", "--listen", "relay.example"]).listen == ("relay.example", 7447)
    options = parser.parse_args(["relay", "--peer", "a", "--peer", "b:1"])
    assert options.peer == [("a", 7447), ("b", 1)]
    for port in ("0", "65534"):
        with pytest.raises(SystemExit, match="the relay needs its port and the next two"):
            main(["relay", "--listen", port])


@pytest.mark.parametrize("number", ["0", "-1", "many"])
def test_the_number_of_members_is_positive(number: str) -> None:
    with pytest.raises(SystemExit):
        build_parser().parse_args(["relay", f"--max-members={number}"])


def test_a_password_file_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="nosuch cannot be read"):
        main(["relay", "--listen", f"{LOOPBACK}:{free_port()}", "--password", str(tmp_path / "nosuch")])
