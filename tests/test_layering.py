"""Imports point one way: cli -> sender, receiver -> face, protocol -> errors."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

EVERYTHING = {"animator", "commands", "sender", "receiver", "face", "protocol", "errors"}
EVERYTHING |= {"render", "output", "transport", "mesh_fitting"}
ROOT = Path(__file__).resolve().parents[1] / "conf"
MAY_IMPORT = {
    "errors": set(),
    "face": {"face", "errors"},
    "protocol": {"protocol", "errors"},
    "render": {"render", "face", "errors", "animator", "receiver"},
    "transport": {"transport", "protocol", "errors"},
    "output": {"output", "render", "face", "protocol", "errors", "animator"},
    "mesh_fitting": {"mesh_fitting", "render", "sender", "face", "errors", "commands"},
    "sender": {"sender", "transport", "face", "protocol", "errors"},
    "receiver": {"receiver", "output", "render", "transport", "face", "protocol", "errors"},
    "animator": {"animator", "output", "render", "receiver", "face", "protocol", "errors"},
    "commands": EVERYTHING,
    "cli": EVERYTHING,
    "__main__": {"cli"},
}
PURE = {"face", "protocol"}
NOT_PURE = {"cv2", "moderngl", "glfw", "imgui_bundle", "socket", "threading", "time", "asyncio", "random", "secrets"}
SOCKETS = {"transport/sender_udp.py", "transport/udp.py"}
WITHOUT_TEST = {"animator/gui/point_overlay.py", "animator/gui/panels/export.py", "errors.py"}
MODULES = sorted(ROOT.rglob("*.py"))


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        match node:
            case ast.Import(names=names):
                yield from (name.name for name in names)
            case ast.ImportFrom(module=str(module), names=names):
                yield from (f"{module}.{name.name}" for name in names)


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    layer = path.relative_to(ROOT).parts[0].removesuffix(".py")
    for name in imports(path):
        top, *rest = name.split(".")
        if top == "conf" and rest:
            assert rest[0] in MAY_IMPORT.get(layer, set()) | {"assets"}, f"{layer} must not import {name}"
        if layer in PURE:
            assert top not in NOT_PURE, f"{layer} is pure and must not import {name}"
        if top == "socket":
            assert str(path.relative_to(ROOT)) in SOCKETS, f"sockets live in {sorted(SOCKETS)}"


def test_only_the_command_line_prints_and_exits() -> None:
    for path in MODULES:
        if path.name == "cli.py":
            continue
        calls = (node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call))
        names = {call.id for call in calls if isinstance(call, ast.Name)}
        assert not names & {"print", "exit", "input", "eval", "exec"}, path


def test_every_module_has_a_test() -> None:
    tests = Path(__file__).parent
    paths = (path.relative_to(ROOT) for path in MODULES if path.stem not in {"__init__", "__main__"})
    untested = {str(path) for path in paths if not (tests / path.parent / f"test_{path.name}").is_file()}
    assert untested == WITHOUT_TEST
