"""The example programs run, stay short, and use public names only."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from conf.face.formats.dpc import read_dpc
from conf.face.mesh.mesh import load_mesh

REPOSITORY = Path(__file__).parents[1]
EXAMPLES = sorted((REPOSITORY / "examples").glob("*.py"))


def run(name: str, *arguments: object) -> str:
    command = [sys.executable, str(REPOSITORY / "examples" / f"{name}.py"), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY, env=None, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_imports_public_names_only(path: Path) -> None:
    text = path.read_text()
    assert len(text.splitlines()) <= 40
    modules = {node.module for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
    assert {module for module in modules if module and module.startswith("conf")} <= {
        "conf.face",
        "conf.protocol",
        "conf.sender",
    }


@pytest.mark.slow
def test_a_mesh_is_deformed(tmp_path: Path) -> None:
    output = tmp_path / "open.obj"
    assert "the largest offset is 1." in run("deform_mesh", output)
    assert len(load_mesh(output).vertices) > 10_000


@pytest.mark.slow
def test_a_clip_becomes_a_dpc_file(tmp_path: Path, carphone_clip: Path) -> None:
    output = tmp_path / "motion.dpc"
    assert "frames with a face" in run("clip_to_dpc", carphone_clip, output)
    motion = read_dpc(output)
    assert motion.units == "fapu" and len(motion.displacements) > 100
    assert motion.fps == pytest.approx(30.0, rel=0.02)


@pytest.mark.slow
def test_motion_survives_a_list_of_losses() -> None:
    text = run("codec_over_losses")
    assert "30 of 80 payloads lost" in text
    assert float(text.split(" B a frame")[0]) < 8.0
    assert float(text.split("mean error of a received frame: ")[1].split("%")[0]) < 6.0


@pytest.mark.slow
def test_a_call_in_memory_connects_and_shows_frames() -> None:
    text = run("call_in_memory")
    shown = int(text.split("; ")[1].split(" frames shown")[0])
    assert 130 <= shown <= 150
