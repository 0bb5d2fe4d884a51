"""The public names of the packages: all there, typed, and not imported before they are used."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import conf
from conf.lazy import lazy_attributes

PACKAGES = ["conf.face", "conf.protocol", "conf.sender"]


@pytest.mark.parametrize("name", PACKAGES)
def test_every_public_name_is_there_and_typed(name: str) -> None:
    package = import_module(name)
    for public in package.__all__:
        assert getattr(package, public) is not None
    assert package.__file__
    tree = ast.parse(Path(package.__file__).read_text())
    typed = {alias.asname for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert typed - {None} == set(package.__all__)
    assert (Path(conf.__file__).parent / "py.typed").is_file()


def test_an_unknown_name_is_an_attribute_error() -> None:
    attribute = lazy_attributes("conf.face", {"Fapu": "fapu"})
    with pytest.raises(AttributeError, match=r"module 'conf\.face' has no attribute 'nothing'"):
        attribute("nothing")


def test_importing_the_packages_imports_no_large_library() -> None:
    program = (
        f"import sys, {', '.join(PACKAGES)}; print(sorted({{'numpy', 'scipy', 'cv2', 'moderngl'}} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_version_is_the_distributions() -> None:
    text = (Path(conf.__file__).parents[1] / "pyproject.toml").read_text()
    assert 'version = { attr = "conf.__version__" }' in text
    assert conf.__version__.count(".") == 2
