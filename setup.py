"""In every build, make the manual page and the completions of shells from the parser of the command line."""

import sys
from pathlib import Path

from setuptools import setup

sys.path.insert(0, str(Path(__file__).resolve().parent))  # a build does not import from the project's folder

from tools.packaging.shell_files import write_shell_files

setup(data_files=write_shell_files(Path("build/shell")))
