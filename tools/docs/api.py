"""Write API pages from the docstrings: `python tools/docs/api.py [FOLDER]`, by default to build/api.

conf.face, conf.protocol and conf.sender import their public names lazily. This program imports all of them, so that
they are listed first on the page of each package.
"""

import sys
from importlib import import_module
from pathlib import Path

import pdoc

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
PACKAGES = ("conf.face", "conf.protocol", "conf.sender")


def main() -> None:
    """Write the pages."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/api")
    for name in PACKAGES:
        package = import_module(name)
        for public in package.__all__:
            setattr(package, public, getattr(package, public))
    pdoc.pdoc("conf", output_directory=folder)
    print(f"{folder / 'index.html'}")


if __name__ == "__main__":
    main()
