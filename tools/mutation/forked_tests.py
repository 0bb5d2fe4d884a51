"""Test the mutants of one module with its own test: `python tools/mutation/forked_tests.py MODULE RESULT`.

mutmut makes the mutants: all of them in one source text, in which the name of the active one selects it. The tests are
collected once, and each mutant is tested in a fork of this process, quick tests first, until one fails. That is several
times as fast as `mutmut run`, which starts pytest for each mutant, and no state passes from one mutant to the next.
"""

import argparse
import difflib
import json
import os
import random
import resource
import signal
import sys
from collections.abc import Callable, Generator, Sequence
from functools import partial
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from time import process_time
from types import CodeType
from typing import Any

import pytest
from mutmut.configuration import config
from mutmut.mutation.file_mutation import mutate_file_contents
from mutmut.mutation.trampoline import set_mutant_under_test
from mutmut.state import state
from mutmut.utils.format_utils import mangled_name_from_mutant_name

ROOT = Path(__file__).resolve().parents[2]
MIN_CPU_S, CPU_FACTOR = (
    2,
    5,
)  # of the time limit of a test: the factor times what it needs without a mutant, and 2 s more
WALL_FACTOR = 30  # of the time limit: a machine may be busy, a mutant may wait for ever
MAX_MEMORY = 8 << 30  # bytes of address space
SAMPLE_SEED = 1
PASSED, FAILED = 0, 1


class MutatedModule(SourceFileLoader):
    """Import one module with all its mutants."""

    def __init__(self, name: str, path: Path) -> None:
        super().__init__(name, str(path))
        self.mutated = mutate_file_contents(str(path), path.read_text())

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Return this loader for its module: a finder of sys.meta_path."""
        return spec_from_file_location(name, self.path, loader=self) if name == self.name else None

    def get_code(self, fullname: str) -> CodeType:
        """Return the code with the mutants."""
        return compile(self.mutated.code, self.path, "exec", dont_inherit=True)

    def changed_lines(self, name: str) -> tuple[str, str]:
        """Return the lines that a mutant changes, before and after, joined by spaces."""
        spans, lines = self.mutated.line_span_by_function_name, self.mutated.code.splitlines()
        original = f"{name.rpartition('_')[0]}_orig"
        before, after = (
            [line.replace(function, "") for line in lines[spans[function].start - 1 : spans[function].end]]
            for function in (original, name)
        )
        parts: dict[str, list[str]] = {"-": [], "+": []}
        for text in difflib.unified_diff(before, after, n=0, lineterm=""):
            if text[0] in parts and text[:3] not in ("---", "+++"):
                parts[text[0]].append(text[1:].strip())
        return " ".join(parts["-"]), " ".join(parts["+"])


class ForkedTests:
    """A pytest plugin that tests every mutant instead of the module."""

    def __init__(self, loader: MutatedModule, names: Sequence[str]) -> None:
        self.results: list[dict[str, object]] = []
        self._names = names
        self._loader = loader
        self._fixture_hits: dict[str, set[str]] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self) -> None:
        """Let Hypothesis shrink no example: the first failure is enough."""
        from hypothesis import Phase, settings  # not at the top: pytest must import it first

        settings.register_profile("mutation", settings.get_profile("fast"), phases=(Phase.explicit, Phase.generate))
        settings.load_profile("mutation")

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any, request: Any) -> Generator[None, Any, Any]:
        """Note what a fixture calls that several tests use."""
        before, state()._stats = state()._stats, set()
        try:
            return (yield)
        finally:
            if fixturedef.scope != "function":
                self._fixture_hits[fixturedef.argname] = set(state()._stats)
            state()._stats |= before

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Stop a fork at its first failure."""
        if report.failed:
            print(f"{report.nodeid} failed\n{report.longreprtext}", file=sys.stderr)  # seen only without a mutant
            os._exit(FAILED)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Test every mutant."""
        durations, callers = self._trace(session.items)
        for name in self._names:
            function = f"{self._loader.name}.{mangled_name_from_mutant_name(name)}"
            first = sorted(callers.get(function, ()), key=lambda i: durations[i])
            # Tests that were not seen to call the function may do so, through something that is cached.
            others = [i for i, item in enumerate(session.items) if i not in first and not is_slow(item)]
            chosen = [(session.items[i], MIN_CPU_S + CPU_FACTOR * durations[i]) for i in (*first, *others)]
            survived = self._in_a_fork(partial(self._test, name, chosen)) == PASSED
            line, changed = self._loader.changed_lines(name)
            self.results.append({"name": name, "line": line, "changed": changed, "survived": survived})
        return True

    def _test(self, name: str, items: list[tuple[pytest.Item, float]]) -> None:
        """Run tests with a mutant, each within some seconds of the CPU."""
        set_mutant_under_test(f"{self._loader.name}.{name}")
        following = [item for item, _ in items[1:]]
        for (item, seconds), next_item in zip(items, [*following, None], strict=True):
            signal.setitimer(signal.ITIMER_PROF, seconds)
            signal.setitimer(signal.ITIMER_REAL, WALL_FACTOR * seconds)
            item.ihook.pytest_runtest_protocol(item=item, nextitem=next_item)

    def _trace(self, items: list[pytest.Item]) -> tuple[list[float], dict[str, set[int]]]:
        """Return the CPU seconds of every test, and which tests call each function."""
        read_end, write_end = os.pipe()

        def trace() -> None:
            set_mutant_under_test("stats")
            durations, callers = [], []
            for item, following in zip(items, [*items[1:], None], strict=True):
                state()._stats.clear()
                begin = process_time()
                item.ihook.pytest_runtest_protocol(item=item, nextitem=following)
                durations.append(process_time() - begin)
                shared = (self._fixture_hits.get(fixture, set()) for fixture in getattr(item, "fixturenames", ()))
                callers.append(sorted(state()._stats.union(*shared)))
            with os.fdopen(write_end, "w") as pipe:
                json.dump((durations, callers), pipe)

        if (child := os.fork()) == 0:
            os.close(read_end)
            leave_after(trace)
        os.close(write_end)
        with os.fdopen(read_end) as pipe:
            text = pipe.read()
        os.waitpid(child, 0)
        if not text:
            raise SystemExit("the tests fail without a mutant")
        durations, callers = json.loads(text)
        by_function: dict[str, set[int]] = {}
        for i, names in enumerate(callers):
            for name in names:
                by_function.setdefault(name, set()).add(i)
        return durations, by_function

    def _in_a_fork(self, function: Callable[[], None]) -> int:
        """Return the exit status of a fork of this process that calls the function without output."""
        if (child := os.fork()) == 0:
            resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
            nowhere = os.open(os.devnull, os.O_WRONLY)
            for stream in (1, 2):
                os.dup2(nowhere, stream)
            leave_after(function)
        return os.waitpid(child, 0)[1]


def leave_after(function: Callable[[], None]) -> None:
    """Call the function and end the process, whatever it raises."""
    status = FAILED
    try:
        function()
        status = PASSED
    finally:
        os._exit(status)


def test_files(module: str) -> list[str]:
    """Return the tests of a module: test_MODULE.py, and each test_MODULE_*.py that is not another module's."""
    folder, _, name = module.rpartition("/")
    tests = sorted((ROOT / "tests" / folder).glob(f"test_{name}_*.py"))
    others = [path for path in tests if not (ROOT / "conf" / folder / path.name.removeprefix("test_")).exists()]
    return [str(path.relative_to(ROOT)) for path in (ROOT / "tests" / folder / f"test_{name}.py", *others)]


def is_slow(item: pytest.Item) -> bool:
    """Return whether a test is marked slow."""
    return item.get_closest_marker("slow") is not None


def main() -> None:
    """Test the mutants of a module and write what each changes and whether it survived."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("module", help="below conf/, such as protocol/session/sequence")
    parser.add_argument("result", type=Path, help="a JSON file")
    parser.add_argument("--quick", action="store_true", help="without the tests that are marked slow")
    parser.add_argument("--sample", type=int, metavar="N", help="N mutants at random instead of all; the seed is fixed")
    args = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    config()  # read in this folder, as tests change it
    loader = MutatedModule(f"conf.{args.module.replace('/', '.')}", ROOT / "conf" / f"{args.module}.py")
    sys.meta_path.insert(0, loader)
    names = loader.mutated.mutant_names
    if args.sample and args.sample < len(names):
        names = random.Random(SAMPLE_SEED).sample(names, args.sample)
    tests = ForkedTests(loader, names)
    options = ["-q", "-p", "no:cacheprovider", "--capture=no", "--assert=plain", "--tb=no"]
    if args.quick:
        options += ["-m", "not slow"]
    pytest.main([*options, *test_files(args.module)], plugins=[tests])
    if len(tests.results) != len(names):
        raise SystemExit("the tests cannot be collected")
    args.result.write_text(json.dumps(tests.results, indent=1))


if __name__ == "__main__":
    main()
