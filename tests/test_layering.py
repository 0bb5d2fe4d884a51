"""Rules of the code base that a program can check: import directions, pure packages, sockets, tests, folder sizes."""

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1] / "conf"
MODULES = {path.relative_to(ROOT).as_posix(): path for path in sorted(ROOT.rglob("*.py"))}

# What each package may import from conf, besides itself and COMMON. Packages to the right know nothing of others:
# cli -> commands -> animator, receiver, sender, mesh_fitting -> output, render, transport -> face, protocol, audio.
COMMON = {"atomic_write", "disk_cache", "errors", "lazy", "stoppable_thread", "thread_priority", "__version__"}
MAY_IMPORT = {
    "errors": set(),
    "atomic_write": set(),
    "lazy": set(),
    "disk_cache": set(),
    "stoppable_thread": set(),
    "thread_priority": set(),
    "settings": set(),
    "audio": set(),
    "face": set(),
    "protocol": set(),
    "render": {"face"},
    "transport": {"protocol"},
    "relay": {"transport", "protocol"},
    "output": {"render", "face", "protocol"},
    "mesh_fitting": {"sender", "render", "face"},
    "sender": {"transport", "audio", "face", "protocol"},
    "receiver": {"output", "render", "transport", "audio", "face", "protocol"},
    "animator": {"output", "render", "face"},
    "call": {"receiver", "sender", "render", "transport", "face", "protocol"},
    "start": {"sender", "render", "face", "transport", "audio", "protocol", "settings"},
    "commands": {
        *("start", "animator", "call", "receiver", "sender", "mesh_fitting", "output", "render", "transport"),
        *("audio", "face", "protocol", "relay", "settings"),
    },
}
MAY_IMPORT["cli"] = MAY_IMPORT["commands"] | {"commands"}
MAY_IMPORT["__main__"] = {"cli"}

# Inside conf/face each level may import the levels before it and, in a folder, the modules of the same folder.
FACE_LEVELS = (
    {"control_points", "interpolation", "rotations"},
    {"fapu", "head_pose", "symmetry", "similarity"},
    {"formats"},
    {"mesh"},
    {"deformation"},
    {"animation", "portrait"},
    {"default_head", "furrows", "head_catalogue", "head_variant", "proportions"},
    {"fitting"},
    {"loading"},
    {"prepared_face"},
    {"retargeting"},
    {"__init__"},
)

# Pure packages do no I/O but reading packaged data and files named by an argument; time and random bytes are arguments.
PURE_STANDARD_LIBRARY = {
    *(
        "array",
        "base64",
        "bisect",
        "codecs",
        "collections",
        "copy",
        "csv",
        "dataclasses",
        "difflib",
        "enum",
        "functools",
    ),
    *(
        "hashlib",
        "hmac",
        "importlib",
        "io",
        "ipaddress",
        "itertools",
        "json",
        "math",
        "operator",
        "re",
        "struct",
        "typing",
        "warnings",
    ),
    *("unicodedata", "urllib", "zipfile", "zlib"),
}
PURE_IMPORTS = {
    "face": PURE_STANDARD_LIBRARY | {"pathlib", "numpy", "scipy"},
    "protocol": PURE_STANDARD_LIBRARY | {"numpy", "msgpack", "cryptography", "spake2"},
}
PURE_EXCEPTIONS = {
    ("face/fitting/painted_eyes.py", "cv2"),  # decodes the texture
    ("face/formats/trimesh_reader.py", "logging"),  # silences trimesh
    ("face/formats/trimesh_reader.py", "trimesh"),
}

SOCKETS = {
    *("transport/udp.py", "transport/local_addresses.py", "transport/wake_up.py", "transport/relay_probe.py"),
    *("relay/front.py", "relay/udp_front.py", "relay/tcp_front.py", "relay/stun_responder.py"),
}
MAX_MODULES = 17  # per folder, without __init__.py
WITHOUT_TEST = {"sender/portrait/captured_face.py"}
# Tests of several modules together, of documents and of the whole program.
WITHOUT_MODULE = {
    *("face/formats/test_gltf_faults.py", "face/formats/test_mesh_faults.py", "sender/capture/test_clip_faults.py"),
    *("protocol/codec/test_golden.py", "protocol/portrait/test_in_a_call.py"),
    *("protocol/session/test_golden.py", "protocol/session/test_state_machine.py"),
    *("protocol/test_capture.py", "protocol/test_golden.py", "protocol/test_wire_document.py", "test_end_to_end.py"),
    *("relay/test_capture.py", "protocol/session/test_lying_relay.py"),
    *("protocol/test_send_leg_voice.py", "protocol/test_two_way_call.py"),
    *("test_documents.py", "test_examples.py", "test_layering.py", "test_readme.py"),
}


@cache
def nodes(path: Path) -> list[ast.AST]:
    """Return all nodes of the syntax tree of a module."""
    return list(ast.walk(ast.parse(path.read_text())))


def imports(path: Path) -> Iterator[str]:
    """Yield the absolute name of everything that a module imports."""
    for node in nodes(path):
        match node:
            case ast.Import(names=names):
                yield from (name.name for name in names)
            case ast.ImportFrom(module=str(module), names=names):
                yield from (f"{module}.{name.name}" for name in names)


def is_allowed(module: str, name: str) -> bool:
    """Return whether the module, a path below conf/, may import what is called name."""
    package, *inner = module.removesuffix(".py").split("/")
    top, *rest = name.split(".")
    if top == "socket" and module not in SOCKETS:
        return False
    if top != "conf":
        return package not in PURE_IMPORTS or top in PURE_IMPORTS[package] or (module, top) in PURE_EXCEPTIONS
    if package == rest[0] == "face":
        return face_level(rest[1]) < face_level(inner[0]) or (len(inner) > 1 and inner[0] == rest[1])
    return rest[0] in MAY_IMPORT.get(package, set()) | {package, *COMMON}


def face_level(name: str) -> int:
    """Return the position in FACE_LEVELS of a module or folder of conf/face."""
    return next(number for number, names in enumerate(FACE_LEVELS) if name in names)


def test_imports_follow_the_layers() -> None:
    found = {(module, name) for module, path in MODULES.items() for name in imports(path)}
    assert {pair for pair in found if not is_allowed(*pair)} == set()


def test_the_whitelists_hold_nothing_unused() -> None:
    used = {(module, name.split(".")[0]) for module, path in MODULES.items() for name in imports(path)}
    assert used >= PURE_EXCEPTIONS
    for package, allowed in PURE_IMPORTS.items():
        of_package = {top for module, top in used if module.startswith(f"{package}/")}
        assert allowed - PURE_STANDARD_LIBRARY <= of_package
    pure = {top for module, top in used if module.split("/")[0] in PURE_IMPORTS}
    assert pure >= PURE_STANDARD_LIBRARY


@pytest.mark.parametrize(
    ("module", "name", "allowed"),
    [
        ("face/fapu.py", "conf.face.control_points.CONTROL_POINTS", True),
        ("face/fapu.py", "conf.face.mesh.mesh.Mesh", False),
        ("face/mesh/editing.py", "conf.face.mesh.mesh.Mesh", True),
        ("face/portrait/warp.py", "conf.face.animation.gaze", False),
        ("face/fapu.py", "conf.protocol.wire", False),
        ("protocol/wire.py", "time", False),
        ("transport/udp.py", "socket", True),
        ("sender/pipeline.py", "socket.socket", False),
        ("sender/pipeline.py", "conf.receiver.hud", False),
        ("sender/pipeline.py", "conf.errors.ConfError", True),
    ],
)
def test_examples_of_allowed_and_forbidden_imports(module: str, name: str, allowed: bool) -> None:
    assert is_allowed(module, name) is allowed


def test_only_the_command_line_prints_and_exits() -> None:
    for path in MODULES.values():
        if path.name == "cli.py":
            continue
        calls = (node.func for node in nodes(path) if isinstance(node, ast.Call))
        names = {call.id for call in calls if isinstance(call, ast.Name)}
        assert not names & {"print", "exit", "input", "eval", "exec"}, path


def test_every_module_has_a_test() -> None:
    tests = Path(__file__).parent
    modules = [Path(module) for module, path in MODULES.items() if path.stem not in {"__init__", "__main__"}]
    untested = {str(module) for module in modules if not (tests / module.parent / f"test_{module.name}").is_file()}
    assert untested == WITHOUT_TEST


def test_every_test_has_a_module() -> None:
    tests, repository = Path(__file__).parent, ROOT.parent
    paths = [path.relative_to(tests) for path in sorted(tests.rglob("test_*.py"))]
    modules = {path: path.with_name(path.name.removeprefix("test_")) for path in paths}
    roots = ROOT, repository
    without = {path for path, module in modules.items() if not any((root / module).is_file() for root in roots)}
    assert {path.as_posix() for path in without} == WITHOUT_MODULE


def test_no_folder_is_too_full() -> None:
    folders = Counter(path.parent for path in MODULES.values() if path.name != "__init__.py")
    assert {str(folder): count for folder, count in folders.items() if count > MAX_MODULES} == {}
