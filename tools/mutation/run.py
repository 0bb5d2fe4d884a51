"""Mutation testing of modules, each with its own test.

    python tools/mutation/run.py protocol/session/sequence sender/motion

Each argument is a module or a package below conf/. A mutant is killed if tests/.../test_MODULE.py fails or exceeds its
time, or a test_MODULE_*.py that belongs to no other module. Mutants in left_out.py do not count. --survivors prints
what the tests did not notice, --report reads the results of earlier runs in build/mutate, --constants lists the
constants, which are not mutated.
"""

import argparse
import ast
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.mutation.left_out import BY_MODULE, EVERYWHERE  # noqa: E402 - the path above

RESULTS = ROOT / "build" / "mutate"


@dataclass(frozen=True)
class Mutant:
    """One changed line. survived : no test failed; reason : why it is left out, empty if it counts"""

    name: str
    line: str
    changed: str
    survived: bool
    reason: str


def left_out_reason(module: str, line: str, changed: str) -> str:
    """Return why a mutant is left out, or an empty text."""
    for pattern, changed_pattern, reason in EVERYWHERE:
        if re.search(pattern, line) and re.search(changed_pattern, changed):
            return reason
    for part, changed_part, reason in BY_MODULE.get(module, ()):
        if part in line and changed_part in changed:
            return reason
    return ""


def modules_of(argument: str) -> list[str]:
    """Return the module, or the modules of the package, below conf/."""
    path = ROOT / "conf" / argument
    if path.with_suffix(".py").is_file():
        return [argument]
    found = [file for file in sorted(path.rglob("*.py")) if file.name != "__init__.py"]
    if not found:
        raise SystemExit(f"conf/{argument} is no module and no package")
    return [file.relative_to(ROOT / "conf").with_suffix("").as_posix() for file in found]


def run(module: str, options: list[str]) -> None:
    """Test the mutants of a module in a process of its own."""
    result = result_of(module)
    result.parent.mkdir(parents=True, exist_ok=True)
    program = Path(__file__).with_name("forked_tests.py")
    command = [sys.executable, str(program), module, str(result), *options]
    if subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode:
        raise SystemExit(f"conf/{module}.py could not be tested")


def result_of(module: str) -> Path:
    """Return the file of a module's results."""
    return RESULTS / f"{module}.json"


def mutants(module: str) -> list[Mutant]:
    """Return the tested mutants of a module. Raises SystemExit if it has not been run."""
    try:
        rows = json.loads(result_of(module).read_text())
    except FileNotFoundError:
        raise SystemExit(f"conf/{module}.py has not been run") from None
    return [Mutant(**row, reason=left_out_reason(module, row["line"], row["changed"])) for row in rows]


def report(modules: list[str], *, survivors: bool) -> None:
    """Print killed and counted mutants by module and package, and the survivors if wanted."""
    killed: dict[str, int] = {}
    counted: dict[str, int] = {}
    left_out: dict[str, int] = {}
    for module in modules:
        found = mutants(module)
        scored = [mutant for mutant in found if not mutant.reason]
        for name in (module, f"{module.rpartition('/')[0]}/", "all"):
            killed[name] = killed.get(name, 0) + sum(not mutant.survived for mutant in scored)
            counted[name] = counted.get(name, 0) + len(scored)
            left_out[name] = left_out.get(name, 0) + len(found) - len(scored)
        if survivors:
            for mutant in scored:
                if mutant.survived:
                    print(f"{module} {mutant.name}\n  - {mutant.line}\n  + {mutant.changed}")
    print(f"{'module':44} {'killed':>7} {'counted':>7} {'%':>6} {'left out':>8}")
    for name in (*modules, *sorted(name for name in killed if name.endswith("/")), "all"):
        percent = f"{100 * killed[name] / counted[name]:6.1f}" if counted[name] else "     -"
        print(f"{name:44} {killed[name]:7} {counted[name]:7} {percent} {left_out[name]:8}")


def constants(module: str) -> Iterator[str]:
    """Yield the numeric constants of a module and of its classes, as written."""
    source = (ROOT / "conf" / f"{module}.py").read_text()
    tree = ast.parse(source)
    bodies = [tree.body, *(node.body for node in tree.body if isinstance(node, ast.ClassDef))]
    for node in (node for body in bodies for node in body):
        value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        if value is not None and any(
            isinstance(part, ast.Constant) and type(part.value) in (int, float) for part in ast.walk(value)
        ):
            yield source.splitlines()[node.lineno - 1].strip()


def main() -> None:
    """Run the tests of the modules and print the score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="+", help="modules or packages below conf/, such as protocol/session/sequence")
    parser.add_argument("--quick", action="store_true", help="without the tests that are marked slow")
    parser.add_argument("--sample", metavar="N", help="N mutants of each module at random; the seed is fixed")
    parser.add_argument("--report", action="store_true", help="read the results of earlier runs")
    parser.add_argument("--survivors", action="store_true", help="print the mutants that no test noticed")
    parser.add_argument("--constants", action="store_true", help="list the constants, which are not mutated, and stop")
    args = parser.parse_args()
    modules = list(dict.fromkeys(module for argument in args.modules for module in modules_of(argument)))
    if args.constants:
        for module in modules:
            for text in constants(module):
                print(f"{module}: {text}")
        return
    options = [*(["--quick"] if args.quick else []), *(["--sample", args.sample] if args.sample else [])]
    for module in modules if not args.report else ():
        run(module, options)
    report(modules, survivors=args.survivors)


if __name__ == "__main__":
    main()
