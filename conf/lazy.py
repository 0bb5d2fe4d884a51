"""Public names of a package, imported when they are first used (PEP 562).

`import conf.face` must not import SciPy, and a module of a package must not import its neighbours through the package.
"""

from collections.abc import Callable, Mapping
from importlib import import_module


def lazy_attributes(package: str, sources: Mapping[str, str], /) -> Callable[[str], object]:
    """Return a module-level `__getattr__` for a package.

    sources : public name -> module that defines it, relative to the package
    """

    def attribute(name: str) -> object:
        if name not in sources:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{sources[name]}"), name)

    return attribute
